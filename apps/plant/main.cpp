#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/command_line.hpp"
#include "common/live_program.hpp"
#include "common/process_setup.hpp"
#include "common/program.hpp"
#include "plant/plant.hpp"
#include "reports/report_options.hpp"
#include "reports/reported_run.hpp"
#include "reports/run_reports.hpp"
#include "reports/status_table.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"
#include "sextant/sim/verdict.hpp"

namespace {

constexpr const char* program_name = "sextant-plant";

struct Options {
  sextant::LiveOptions live{.config = "configs/plant.toml"};
  std::string scenario{};
  std::filesystem::path out{};
  sextant::reports::ReportOptions reports{};
};

constexpr const char* scenario_option = "--scenario";

constexpr const char* examples = R"(Examples:
  sextant-plant                                 configs/plant.toml as it stands
  sextant-ecu configs/ecu_hil.toml              the drive that belongs to it, in another shell
  sextant-plant --set hil.pacing=lockstep       virtual time: the plant waits for the drive
  sextant-plant --duration 10 --set period_us=250 --set load.torque_nm.value=5
  sextant-plant --set hil.pacing=lockstep --scenario configs/scenarios/reversal.toml --junit out/junit.xml
                                                evaluates the scenario that the drive plays
  sextant-plant --print-config                  every key with unit, range and meaning
It ends on SIGINT, SIGTERM or SIGHUP. Without a running drive its gates are off.
)";

/// Returns on a signal, with its number, and with 0 at the end of the duration or when the plant has ended.
int run_until_end(sextant::plant::Plant& plant, const sigset_t& signals, std::optional<double> duration_s) {
  constexpr timespec poll_interval{0, 20'000'000};
  const std::int64_t begin_ns = sextant::now_ns();
  const double limit_ns = duration_s.value_or(1e9) * 1e9;
  while (double(sextant::now_ns() - begin_ns) < limit_ns && !plant.ended()) {
    if (const int signal = sigtimedwait(&signals, nullptr, &poll_interval); signal > 0) return signal;
    plant.log_events();
    plant.poll_faults();
  }
  return 0;
}

/// From its start to its report; the number of the signal that has ended it, else 0.
int run_plant(sextant::plant::Plant& plant, const sigset_t& signals, const sextant::LiveOptions& options) {
  plant.start();
  const int signal = run_until_end(plant, signals, options.duration_s);
  plant.stop();
  plant.log_events();
  plant.print_report(stdout);
  return signal;
}

/// What a request of the fault socket makes of the configuration.
sextant::FaultInjection::Read fault_reader(const sextant::LiveOptions& options) {
  return [&options](const std::vector<std::string>& faults) {
    return sextant::load_plant_config(options.config, options.overrides_with(faults)).plant.io.fault;
  };
}

/// Evaluates the scenario that the drive of a lockstep plays.
int run_scenario(const Options& options, const sextant::PlantConfig& config,
                 const sextant::Scenario& scenario, const sigset_t& signals) {
  using namespace sextant;
  reports::RunReports reports{options.reports, {scenario.name}, program_name};
  int signal = 0;
  const auto simulate = [&](TraceRecorder*) {
    plant::Plant plant{config, options.live.fault_socket, fault_reader(options.live), &scenario};
    signal = run_plant(plant, signals, options.live);
    const MilResult result = plant.result();
    if (result.stopped && signal == 0)
      throw std::runtime_error{"the drive left before the scenario had ended"};
    return result;
  };
  const Verdict verdict =
      reports::ReportedRun{.program = program_name,
                           .scenario = scenario,
                           .plant = config.plant,
                           .configuration = config_json(config),
                           .out = options.out,
                           .is_expectation_required = options.reports.require_expectations,
                           .simulate = simulate}
          .run(reports);
  return exit_status(verdict, options.reports.require_expectations) + signal;
}

int run(const Options& options, const sextant::PlantConfig& config,
        const std::optional<sextant::ScenarioConfig>& scenario) {
  // Blocked before any thread starts, so that only run_until_end gets them.
  const sigset_t signals = sextant::block_leave_signals();
  sextant::RealtimeParameters realtime = config.realtime;
  if (config.hil.pacing == sextant::Pacing::lockstep) realtime.cpu = -1;  // no thread is bound to one
  sextant::set_up_process(realtime);
  if (scenario) return run_scenario(options, config, scenario->scenario, signals);
  sextant::plant::Plant plant{config, options.live.fault_socket, fault_reader(options.live)};
  run_plant(plant, signals, options.live);
  return sextant::status_after(program_name, plant.problem());
}

/// A scenario for this plant. Throws std::runtime_error with one sentence.
sextant::ScenarioConfig read_scenario(const std::string& file) {
  sextant::ScenarioConfig config = sextant::load_scenario_config(file);
  if (config.mode != sextant::ScenarioMode::sampled || config.cycle.drives_vehicle())
    throw std::runtime_error{file +
                             ": an event-exact run and a vehicle need the scenario's own drive and plant: "
                             "run it with sextant-mil"};
  return config;
}

int run(const Options& options) {
  std::optional<sextant::ScenarioConfig> scenario;
  sextant::PlantConfig config;
  try {
    if (!options.scenario.empty()) scenario = read_scenario(options.scenario);
    config = sextant::load_plant_config(options.live.config, options.live.overrides);
  } catch (const std::exception& problem) {
    const std::string name = std::filesystem::path{options.scenario}.stem().string();
    if (!options.scenario.empty())
      sextant::reports::report_not_started(program_name, options.reports, {name}, problem.what());
    throw;
  }
  if (!options.live.print_config) return run(options, config, scenario);
  std::fputs(sextant::print_config(config).c_str(), stdout);
  return sextant::ExitStatus::done;
}

std::vector<sextant::Option> all_options(Options& options) {
  std::vector<sextant::Option> all = sextant::live_options(options.live, "end after this time [s]");
  all.push_back({.name = scenario_option,
                 .value = &options.scenario,
                 .what = "scenario that the drive of a lockstep plays: its load, and its [expect]",
                 .type_name = "SCENARIO.toml",
                 .excludes = {"--duration", "--print-config"}});
  all.push_back({.name = "--out",
                 .value = &options.out,
                 .what = "directory for the summary of the scenario",
                 .needs = scenario_option});
  for (const sextant::Option& option : sextant::reports::report_options(options.reports, scenario_option))
    all.push_back(option);
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  sextant::start_log(program_name);
  Options options;
  const std::string help = examples + sextant::exit_status_table() +
                           "With --scenario, by the verdict of the run:\n" +
                           sextant::reports::verdict_status_table();
  const sextant::CommandLine line{program_name,
                                  "Sextant: the plant in a process of its own, for a drive in another one.",
                                  help.c_str(), all_options(options)};
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return sextant::run_program(program_name, [&] { return run(options); });
}
