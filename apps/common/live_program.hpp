#pragma once

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line.hpp"

namespace sextant {

/// The common options of the programs that run until a signal.
struct LiveOptions {
  std::string config{};
  std::optional<double> duration_s{};
  std::vector<std::string> overrides{};
  bool print_config{false};
  std::string fault_socket{};  ///< empty: none
  bool is_config_given{false};

  /// The overrides, and more behind them.
  [[nodiscard]] std::vector<std::string> overrides_with(const std::vector<std::string>& more) const {
    std::vector<std::string> all = overrides;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

/// The options that fill them in. duration: what `--duration` does.
[[nodiscard]] std::vector<Option> live_options(LiveOptions& options, const char* duration);

/// The log goes to stderr, with the time of day and the seconds of CLOCK_MONOTONIC.
void start_log(const std::string& name);

/// Blocks the signals that end a program, for this thread and all that it starts, and returns them
/// for sigwaitinfo() and its kin: no other thread gets them. SIGHUP, of a terminal that is closed, is one of
/// them unless it was ignored. A pipe whose reader has left does not end the program: what is written to it
/// is lost.
[[nodiscard]] sigset_t block_leave_signals();

}  // namespace sextant
