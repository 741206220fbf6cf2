#include "common/live_program.hpp"

#include <ctime>
#include <iterator>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

/// Whether the program was started with the signal ignored, as by nohup.
bool is_ignored(int signal) {
  struct sigaction action{};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// Seconds of CLOCK_MONOTONIC, on which the `t_ns` of recordings and telemetry count.
class MonotonicSeconds final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg&, const std::tm&, spdlog::memory_buf_t& line) override {
    fmt::format_to(std::back_inserter(line), "{:.6f}", double(now_ns()) * 1e-9);
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<MonotonicSeconds>();
  }
};

}  // namespace

std::vector<Option> live_options(LiveOptions& options, const char* duration) {
  return {{.name = "config",
           .value = &options.config,
           .what = "configuration file",
           .given = &options.is_config_given},
          {.name = "--duration", .value = &options.duration_s, .what = duration, .least = 0.001, .most = 1e9},
          {.name = "--set", .value = &options.overrides, .what = "key=value, overrides the file"},
          {.name = "--print-config",
           .value = &options.print_config,
           .what = "print the configuration in force and exit"},
          {.name = "--fault-socket",
           .value = &options.fault_socket,
           .what = "take faults of the simulated plant on this local socket while it runs (scripts/inject)",
           .type_name = "FILE"}};
}

void start_log(const std::string& name) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<MonotonicSeconds>('*').set_pattern("%H:%M:%S.%e %* %^%l%$ %v");
  spdlog::set_formatter(std::move(formatter));
}

sigset_t block_leave_signals() {
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
