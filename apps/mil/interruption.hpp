#pragma once

#include <array>
#include <csignal>

namespace sextant::mil {

/// SIGINT and SIGTERM end a run in order; a second one of them ends the program at once.
class Interruption {
 public:
  Interruption() {
    struct sigaction action{};
    action.sa_handler = [](int signal) { caught = signal; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
  }

  /// The signal that has come; 0 while none has.
  [[nodiscard]] int signal() const noexcept { return caught; }

  /// Exit status of a program that a signal has ended, as shells count.
  [[nodiscard]] int status() const noexcept { return 128 + caught; }

 private:
  static inline volatile std::sig_atomic_t caught = 0;
};

}  // namespace sextant::mil
