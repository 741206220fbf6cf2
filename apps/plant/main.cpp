#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "plant/plant.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace {

struct Options {
  std::string config{"configs/plant.toml"};
  std::optional<double> duration_s{};
  std::vector<std::string> overrides{};
  bool print_config{false};
};

constexpr const char* examples = R"(Examples:
  sextant-plant                                 configs/plant.toml as it stands
  sextant-ecu configs/ecu_hil.toml              the drive that belongs to it, in another shell
  sextant-plant --set hil.pacing=lockstep       virtual time: the plant waits for the drive
  sextant-plant --duration 10 --set period_us=250 --set load.torque_nm.value=5
  sextant-plant --print-config                  every key with unit, range and meaning
It leaves on SIGINT or SIGTERM. Without a living drive its gates are open.)";

/// Adds the options to the command line; the result refers to `options`.
void describe(CLI::App& app, Options& options) {
  app.footer(examples);
  app.add_option("config", options.config, "configuration file")->capture_default_str();
  app.add_option("--duration", options.duration_s, "leave after so many seconds")
      ->check(CLI::Range(0.001, 1e9));
  app.add_option("--set", options.overrides, "key=value, overrides the file")->take_all()->expected(1);
  app.add_flag("--print-config", options.print_config, "print the configuration in force and leave");
  app.set_version_flag("--version", SEXTANT_VERSION);
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return "sextant-plant: " + std::string{error.what()} + "; sextant-plant --help tells more\n";
  });
}

sigset_t leave_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

/// Returns when a signal asks to leave, the time is over, or the plant has ended by itself.
void run_until_end(sextant::plant::Plant& plant, const sigset_t& signals, std::optional<double> duration_s) {
  constexpr timespec look{0, 20'000'000};
  const std::int64_t begin_ns = sextant::now_ns();
  const double limit_ns = duration_s.value_or(1e9) * 1e9;
  while (double(sextant::now_ns() - begin_ns) < limit_ns && !plant.ended()) {
    if (sigtimedwait(&signals, nullptr, &look) > 0) return;
    plant.tell_news();
  }
}

int run(const Options& options) {
  const sextant::PlantConfig config = sextant::load_plant_config(options.config, options.overrides);
  if (options.print_config) {
    std::fputs(sextant::print_config(config).c_str(), stdout);
    return 0;
  }
  // Blocked before any thread starts, so that only run_until_end gets them.
  const sigset_t signals = leave_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  sextant::plant::Plant plant{config};
  plant.start();
  run_until_end(plant, signals, options.duration_s);
  plant.stop();
  plant.tell_news();
  plant.print_report(stdout);
  if (!plant.problem().empty()) throw std::runtime_error(plant.problem());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("sextant-plant"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  CLI::App app{"Sextant: the plant in a process of its own, for a drive in another one."};
  Options options;
  describe(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "sextant-plant: %s\n", problem.what());
    return 1;
  }
}
