#pragma once

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace sextant {

/// The common options of the programs that run until a signal.
struct LiveOptions {
  std::string config{};
  std::optional<double> duration_s{};
  std::vector<std::string> overrides{};
  bool print_config{false};
};

/// Adds the options; the result refers to `options`. duration: help of `--duration`.
inline void describe_live(CLI::App& app, LiveOptions& options, const char* duration) {
  app.add_option("config", options.config, "configuration file")->capture_default_str();
  app.add_option("--duration", options.duration_s, duration)->check(CLI::Range(0.001, 1e9));
  app.add_option("--set", options.overrides, "key=value, overrides the file")->take_all()->expected(1);
  app.add_flag("--print-config", options.print_config, "print the configuration in force and exit");
}

/// The log goes to stderr, with the time of day.
inline void start_log(const std::string& name) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
}

/// Whether the program was started with the signal ignored, as by nohup.
[[nodiscard]] inline bool is_ignored(int signal) {
  struct sigaction action{};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// Blocks the signals that end a program, for this thread and all that it starts, and returns them for
/// sigwaitinfo() and sigtimedwait(). SIGHUP, of a closed terminal, is one of them unless it was ignored.
/// SIGPIPE is ignored: output to a closed pipe is lost.
[[nodiscard]] inline sigset_t block_leave_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  if (!is_ignored(SIGHUP)) sigaddset(&set, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGCHLD, SIG_DFL);  // if it were ignored, waitpid() would not report the end of a child
  return set;
}

}  // namespace sextant
