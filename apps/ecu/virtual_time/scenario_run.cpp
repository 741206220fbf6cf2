#include "ecu/virtual_time/scenario_run.hpp"

#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>

#include "common/exit_status.hpp"
#include "common/program.hpp"
#include "ecu/unit/power_stage.hpp"
#include "reports/interruption.hpp"
#include "reports/reported_run.hpp"
#include "reports/run_reports.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/sim/observed_power_stage.hpp"
#include "sextant/sim/scenario_commands.hpp"
#include "sextant/sim/scenario_mark.hpp"

namespace sextant::ecu {
namespace {

/// What is played, and by which drive.
struct Played {
  ScenarioConfig scenario{};
  EcuConfig config{};
  std::string configuration{};  ///< in force, as JSON
};

/// Throws where a plant in another process, which evaluates the scenario by itself, leaves options without a
/// meaning.
void require_no_reports(const ScenarioRunOptions& options) {
  const reports::ReportOptions& reports = options.reports;
  if (!reports.junit.empty() || !reports.summary_markdown.empty() || !options.out.empty() ||
      reports.require_expectations)
    throw std::runtime_error{
        "the plant is in another process, which evaluates the scenario: give --junit, --summary-markdown, "
        "--out and --require-expectations to sextant-plant --scenario"};
}

/// Throws where nothing evaluates the scenario.
void require_observed_plant(const EcuConfig& config, const ScenarioRunOptions& options) {
  if (config.power_stage != PowerStageKind::own) return;
  throw std::runtime_error{options.scenario + ": power_stage = \"" + config.own_name +
                           "\" evaluates no scenario; play a --profile, or take the simulated plant"};
}

Played read(const ScenarioRunOptions& options) {
  const bool is_own = options.config.empty();
  if (!options.run.log.empty())
    throw std::runtime_error{"commands come from the recording " + options.run.log +
                             " or from the scenario " + options.scenario + ", not from both"};
  Played played;
  played.scenario = load_scenario_config(
      options.scenario, is_own ? options.overrides : std::vector<std::string>{}, options.own.methods);
  if (played.scenario.mode != ScenarioMode::sampled)
    throw std::runtime_error{options.scenario +
                             ": an event-exact run has no drive for virtual time: run it with sextant-mil"};
  if (is_own) {
    // Each wake-up runs one period: the scenario has no key for it.
    played.config.realtime.wake_every_periods = 1;
    played.config.drive = played.scenario.drive;
    played.configuration = config_json(played.scenario);
    return played;
  }
  if (played.scenario.cycle.drives_vehicle())
    throw std::runtime_error{options.scenario +
                             ": the vehicle of the cycle belongs to the scenario's own drive: leave " +
                             options.config + " out"};
  played.config = load_ecu_config(options.config, options.overrides, options.own);
  require_observed_plant(played.config, options);
  require_waiting_plant(played.config);
  if (played.config.power_stage != PowerStageKind::simulated) require_no_reports(options);
  played.configuration = config_json(played.config);
  return played;
}

Played read_reported(const std::string& program, const ScenarioRunOptions& options) {
  try {
    return read(options);
  } catch (const std::exception& problem) {
    report_not_started(program, options, problem.what());
    throw;
  }
}

/// Observed in this process.
int run_here(const std::string& program, const ScenarioRunOptions& options, const Played& played) {
  const Scenario& scenario = played.scenario.scenario;
  const DriveConfig& drive = played.config.drive;
  const std::int32_t period_ns = drive.drive.period_ns;
  reports::RunReports reports{options.reports, {scenario.name}, program};
  const reports::Interruption interruption;
  const auto simulate = [&](TraceRecorder* trace) {
    ObservedPowerStage stage{scenario, drive.plant};
    VirtualRun run{{.drives = {played.config}},
                   options.run,
                   {&stage.io()},
                   [&]() -> std::string {
                     return stage.has_ended() || interruption.signal() != 0 ? "the run is over" : "";
                   },
                   VirtualScenario{.name = scenario.name,
                                   .begin_ns = ObservedPowerStage::begin_ns(period_ns),
                                   .duration_ns = scenario.duration_ns,
                                   .torque = [&](std::int64_t t_ns) { return stage.torque(t_ns); },
                                   .observer = [&](const Telemetry<double>& t) { stage.period(t); }}};
    stage.start(&run.controller(), trace);
    run.run();
    run.print_report(stdout);
    return stage.result();
  };
  const TraceOrigin trace{scenario.name, period_ns, drive.method().channels()};
  const Verdict verdict =
      reports::ReportedRun{.program = program,
                           .scenario = scenario,
                           .plant = drive.plant,
                           .configuration = played.configuration,
                           .out = options.out,
                           .trace = options.no_trace ? std::nullopt : std::optional{trace},
                           .is_expectation_required = options.reports.require_expectations,
                           .simulate = simulate}
          .run(reports);
  if (interruption.signal() != 0) return interruption.status();
  return exit_status(verdict, options.reports.require_expectations);
}

/// Observed by a plant in lockstep.
int run_in_lockstep(const std::string& program, const ScenarioRunOptions& options, const Played& played) {
  const Scenario& scenario = played.scenario.scenario;
  const std::int64_t begin_ns = ObservedPowerStage::begin_ns(played.config.drive.drive.period_ns);
  const std::uint32_t mark = scenario_mark(scenario);
  ScenarioCommands commands{scenario};
  PowerStage stage{played.config};
  VirtualRun run{
      {.drives = {played.config}},
      options.run,
      {&stage.io()},
      [&] { return stage.problem(); },
      VirtualScenario{.name = scenario.name,
                      .begin_ns = begin_ns,
                      .duration_ns = scenario.duration_ns,
                      .torque = [&](std::int64_t t_ns) { return commands.reference(t_ns - begin_ns); },
                      .observer = [&](const Telemetry<double>& t) { stage.report(t, begin_ns, mark); }}};
  run.run();
  run.print_report(stdout);
  if (const std::string problem = stage.problem(); !problem.empty())
    return status_after(program.c_str(), problem);
  if (const std::string reason = run.reason(); !reason.empty())
    std::fprintf(stderr, "%s: %s\n", program.c_str(), reason.c_str());
  return exit_status(run.verdict());
}

}  // namespace

void report_not_started(const std::string& program, const ScenarioRunOptions& options,
                        const std::string& why) {
  if (options.scenario.empty()) return;
  const std::string name = std::filesystem::path{options.scenario}.stem().string();
  reports::report_not_started(program, options.reports, {name}, why);
}

int run_scenario(const std::string& program, const ScenarioRunOptions& options) {
  const Played played = read_reported(program, options);
  switch (played.config.power_stage) {
    case PowerStageKind::simulated:
      return run_here(program, options, played);
    case PowerStageKind::shared_memory:
    case PowerStageKind::udp:
    case PowerStageKind::own:  // refused
      break;
  }
  return run_in_lockstep(program, options, played);
}

}  // namespace sextant::ecu
