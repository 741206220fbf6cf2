#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "ecu/ecu.hpp"
#include "sextant/config/load_config.hpp"

namespace {

struct Options {
  std::string config{"configs/ecu.toml"};
  std::optional<std::string> can{};
  std::optional<double> duration_s{};
  std::vector<std::string> overrides{};
  bool print_config{false};
};

constexpr const char* examples = R"(Examples:
  sextant-ecu                                        configs/ecu.toml as it stands
  sextant-ecu --can udp_multicast:239.74.163.2:43113 a bus for machines without CAN
  sextant-ecu --duration 10 --set plant.integrator=fixed --set realtime.priority=90
  sextant-ecu --print-config                         every key with unit, range and meaning
It leaves on SIGINT or SIGTERM: torque to zero, gates off.)";

/// Adds the options to the command line; the result refers to `options`.
void describe(CLI::App& app, Options& options) {
  app.footer(examples);
  app.add_option("config", options.config, "configuration file")->capture_default_str();
  app.add_option("--can", options.can, "CAN bus: socketcan:<interface> or udp_multicast:<group>:<port>");
  app.add_option("--duration", options.duration_s, "leave after so many seconds")
      ->check(CLI::Range(0.001, 1e9));
  app.add_option("--set", options.overrides, "key=value, overrides the file")->take_all()->expected(1);
  app.add_flag("--print-config", options.print_config, "print the configuration in force and leave");
  app.set_version_flag("--version", SEXTANT_VERSION);
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return "sextant-ecu: " + std::string{error.what()} + "; sextant-ecu --help tells more\n";
  });
}

sigset_t leave_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

/// Returns when a signal asks to leave or the time is over.
void wait_for_end(const sigset_t& signals, std::optional<double> duration_s) {
  if (!duration_s) {
    while (sigwaitinfo(&signals, nullptr) < 0) {
    }
    return;
  }
  const auto whole = static_cast<time_t>(*duration_s);
  const timespec limit{whole, static_cast<long>((*duration_s - double(whole)) * 1e9)};
  (void)sigtimedwait(&signals, nullptr, &limit);
}

int run(const Options& options) {
  sextant::EcuConfig config = sextant::load_ecu_config(options.config, options.overrides);
  if (options.can) config.can.bus = *options.can;
  if (options.print_config) {
    std::fputs(sextant::print_config(config).c_str(), stdout);
    return 0;
  }
  // Blocked before any thread starts, so that only wait_for_end gets them.
  const sigset_t signals = leave_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  sextant::ecu::Ecu ecu{config};
  ecu.start();
  wait_for_end(signals, options.duration_s);
  ecu.stop();
  ecu.print_report(stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("sextant-ecu"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  CLI::App app{"Sextant: the live drive. Takes torque commands over CAN, publishes telemetry over DDS."};
  Options options;
  describe(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "sextant-ecu: %s\n", problem.what());
    return 1;
  }
}
