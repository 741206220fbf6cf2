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

#include <fmt/format.h>

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
#include "sextant/run/verdict.hpp"

namespace {

constexpr const char* program_name = "sextant-plant";

struct Options {
  sextant::LiveOptions live{.config = "configs/plant.toml"};
  std::string scenario{};
  std::filesystem::path out{};
  double join_within_s{60};
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
It ends on SIGINT, SIGTERM or SIGHUP. Without a running drive its gates are off. With --scenario it ends where
no drive joins within --join-within, with status 1.
)";

/// A problem that has ended a run.
class RunProblem : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Limits of the time for which a plant runs [s].
struct TimeLimits {
  std::optional<double> duration_s{};
  std::optional<double> join_within_s{};  ///< without a drive in lockstep
};

/// Returns on a signal, with its number, and with 0 at a limit of time or when the plant has ended.
int run_until_end(sextant::plant::Plant& plant, const sigset_t& signals, const TimeLimits& limits) {
  constexpr timespec poll_interval{0, 20'000'000};
  constexpr double unlimited_s = 1e9;
  const std::int64_t begin_ns = sextant::now_ns();
  const auto has_time = [&] {
    const double run_s = double(sextant::now_ns() - begin_ns) * 1e-9;
    return run_s < limits.duration_s.value_or(unlimited_s) &&
           (plant.has_joined() || run_s < limits.join_within_s.value_or(unlimited_s));
  };
  while (has_time() && !plant.ended()) {
    if (const int signal = sigtimedwait(&signals, nullptr, &poll_interval); signal > 0) return signal;
    plant.log_events();
    plant.poll_faults();
  }
  return 0;
}

/// From its start to its report; the number of the signal that has ended it, else 0.
int run_plant(sextant::plant::Plant& plant, const sigset_t& signals, const TimeLimits& limits) {
  plant.start();
  const int signal = run_until_end(plant, signals, limits);
  plant.stop();
  plant.log_events();
  plant.print_report(stdout);
  return signal;
}

/// The result of a scenario that no signal has ended. Throws RunProblem where it has not run to its end, and
/// std::runtime_error where the drive has not played it, with one sentence.
sextant::MilResult whole_result(const sextant::plant::Plant& plant, const Options& options) {
  if (!plant.problem().empty()) throw RunProblem{plant.problem()};
  if (!plant.has_joined())
    throw RunProblem{fmt::format(
        "no drive has joined within {:g} s: start sextant-ecu --virtual-time --scenario with the same file",
        options.join_within_s)};
  if (const std::string other = plant.other_play(); !other.empty()) throw std::runtime_error{other};
  sextant::MilResult result = plant.result();
  if (result.stopped) throw RunProblem{"the drive left before the scenario had ended"};
  return result;
}

/// Evaluates the scenario that the drive of a lockstep plays.
int run_scenario(const Options& options, const sextant::PlantConfig& config,
                 const sextant::Scenario& scenario, const sigset_t& signals) {
  using namespace sextant;
  reports::RunReports reports{options.reports, {scenario.name}, program_name};
  int signal = 0;
  const auto simulate = [&](TraceRecorder*) {
    plant::Plant plant{config, options.live.fault_socket, &scenario};
    signal = run_plant(plant, signals, {.join_within_s = options.join_within_s});
    return signal != 0 ? plant.result() : whole_result(plant, options);
  };
  const reports::ReportedRun run{.program = program_name,
                                 .scenario = scenario,
                                 .plant = config.plant,
                                 .configuration = config_json(config),
                                 .out = options.out,
                                 .is_expectation_required = options.reports.require_expectations,
                                 .simulate = simulate};
  try {
    const Verdict verdict = run.run(reports);
    return signal != 0 ? exit_status(Verdict::interrupted) + signal
                       : exit_status(verdict, options.reports.require_expectations);
  } catch (const RunProblem& problem) {
    return status_after(program_name, problem.what());
  }
}

int run(const Options& options, const sextant::PlantConfig& config,
        const std::optional<sextant::ScenarioConfig>& scenario) {
  // Blocked before any thread starts, so that only run_until_end gets them.
  const sigset_t signals = sextant::block_leave_signals();
  sextant::RealtimeParameters realtime = config.realtime;
  if (config.hil.pacing == sextant::Pacing::lockstep) realtime.cpu = -1;  // no thread is bound to one
  sextant::set_up_process(realtime);
  if (scenario) return run_scenario(options, config, scenario->scenario, signals);
  sextant::plant::Plant plant{config, options.live.fault_socket};
  run_plant(plant, signals, {.duration_s = options.live.duration_s});
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

/// Reports of a scenario, if there is one, that has not run.
void report_not_started(const Options& options, const std::string& why) {
  if (options.scenario.empty()) return;
  const std::string name = std::filesystem::path{options.scenario}.stem().string();
  sextant::reports::report_not_started(program_name, options.reports, {name}, why);
}

int run(const Options& options) {
  std::optional<sextant::ScenarioConfig> scenario;
  sextant::PlantConfig config;
  try {
    if (!options.scenario.empty()) scenario = read_scenario(options.scenario);
    config = sextant::load_plant_config(options.live.config, options.live.overrides);
  } catch (const std::exception& problem) {
    report_not_started(options, problem.what());
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
  all.push_back({.name = "--join-within",
                 .value = &options.join_within_s,
                 .what = "end where no drive joins within this time; by default 60 [s]",
                 .needs = scenario_option,
                 .least = 0.001,
                 .most = 1e6});
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
  const sextant::CommandLine line{
      program_name, "Sextant: the plant in a process of its own, for a drive in another one.", help.c_str(),
      all_options(options), [&options](const std::string& why) { report_not_started(options, why); }};
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return sextant::run_program(program_name, [&] { return run(options); });
}
