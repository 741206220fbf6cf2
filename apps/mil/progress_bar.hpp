#pragma once

#include <algorithm>
#include <cstdio>
#include <string>

#include <unistd.h>

namespace sextant::mil {

/// A progress bar on a terminal; nothing elsewhere.
class ProgressBar {
 public:
  ProgressBar(std::string title, std::FILE* out)
      : title_{std::move(title)}, out_{out}, shown_{isatty(fileno(out)) != 0} {}

  /// fraction 0…1. Always true: the run goes on.
  bool show(double fraction) {
    if (!shown_) return true;
    constexpr int width = 40;
    const int done = int(std::clamp(fraction, 0.0, 1.0) * width);
    std::fprintf(out_, "\r%s [%s%s] %3.0f %%", title_.c_str(), std::string(std::size_t(done), '#').c_str(),
                 std::string(std::size_t(width - done), '.').c_str(), 100.0 * fraction);
    std::fflush(out_);
    return true;
  }

  /// Removes the bar.
  void finish() {
    if (shown_) std::fputs("\r\033[K", out_);
  }

 private:
  std::string title_;
  std::FILE* out_;
  bool shown_;
};

}  // namespace sextant::mil
