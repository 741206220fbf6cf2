#include "ecu/virtual_time/scenario_run.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/exit_status.hpp"
#include "common/outcome.hpp"
#include "common/program.hpp"
#include "ecu/unit/power_stage.hpp"
#include "reports/interruption.hpp"
#include "reports/reported_run.hpp"
#include "reports/run_reports.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/run/observed_power_stage.hpp"
#include "sextant/run/scenario_commands.hpp"
#include "sextant/run/scenario_mark.hpp"

namespace sextant::ecu {
namespace {

/// What is played, and by which drives.
struct Played {
  ScenarioConfig scenario{};
  DrivesConfig config{};
  std::vector<std::string> configurations{};  ///< in force, as JSON, of each drive
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
  if (config.power_stage_kind() != PowerStageKind::own) return;
  throw std::runtime_error{options.scenario + ": power_stage = \"" + config.power_stage +
                           "\" evaluates no scenario; play a --profile, or take the simulated plant"};
}

/// Time zero of a scenario on the clock of a drive. [ns]
std::int64_t begin_ns(const EcuConfig& drive) {
  return ObservedPowerStage::begin_ns(drive.drive.drive.period_ns);
}

/// Throws where a drive of the configuration cannot play a scenario.
void require_playable(const DrivesConfig& config, const ScenarioRunOptions& options) {
  const auto is_here = [](const EcuConfig& drive) {
    return drive.power_stage_kind() == PowerStageKind::simulated;
  };
  for (const EcuConfig& drive : config.drives) {
    require_observed_plant(drive, options);
    require_waiting_plant(drive);
    if (!is_here(drive)) require_no_reports(options);
    if (begin_ns(drive) != begin_ns(config.drives.front())) {
      throw std::runtime_error{options.config +
                               ": a scenario begins with a control period of each drive: give the drives one "
                               "drive.period_us"};
    }
    if (is_here(drive) == is_here(config.drives.front())) continue;
    throw std::runtime_error{options.config +
                             ": of the drives that play a scenario some have their plant in this process and "
                             "some in another one: give all the same power_stage"};
  }
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
    EcuConfig drive;
    drive.realtime.wake_every_periods = 1;
    drive.drive = played.scenario.drive;
    played.config.drives = {drive};
    played.configurations = {config_json(played.scenario)};
    return played;
  }
  if (played.scenario.cycle.drives_vehicle())
    throw std::runtime_error{options.scenario +
                             ": the vehicle of the cycle belongs to the scenario's own drive: leave " +
                             options.config + " out"};
  played.config = load_drives_config(options.config, options.overrides, options.own);
  require_playable(played.config, options);
  for (const EcuConfig& drive : played.config.drives) played.configurations.push_back(config_json(drive));
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

/// The scenario of each drive, which has the drive's id in its name where there are several.
std::vector<Scenario> scenarios_of(const Played& played) {
  std::vector<Scenario> scenarios;
  for (const EcuConfig& drive : played.config.drives) {
    Scenario& own = scenarios.emplace_back(played.scenario.scenario);
    if (played.config.drives.size() > 1) own.name += "_" + std::to_string(drive.drive_id);
  }
  return scenarios;
}

/// The drives of a scenario whose plants are in this process: one run, in which each drive is observed,
/// evaluated and reported.
class ObservedRun {
 public:
  ObservedRun(const std::string& program, const ScenarioRunOptions& options, const Played& played)
      : options_{options},
        config_{played.config},
        scenarios_{scenarios_of(played)},
        files_{options.reports, names(), program},
        traces_(scenarios_.size()),
        outcomes_(scenarios_.size()) {
    for (std::size_t k = 0; k < scenarios_.size(); ++k) runs_.push_back(reported(program, played, k));
  }

  /// Exit status.
  int run() {
    outcomes_.front() = outcome_of([this] { return runs_.front().result(); });
    // What kept the run from its end keeps every drive from a result.
    for (std::size_t k = 1; k < outcomes_.size(); ++k) {
      if (!outcomes_[k].result && !outcomes_[k].problem) outcomes_[k].problem = outcomes_[k - 1].problem;
    }
    Verdict first = Verdict::pass;  // in the order of the verdicts
    std::exception_ptr problem;
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      try {
        first = std::min(first, runs_[k].report(outcomes_[k], files_));
      } catch (...) {
        if (!problem) problem = std::current_exception();
      }
    }
    if (problem) std::rethrow_exception(problem);
    if (interruption_.signal() != 0) return interruption_.status();
    return exit_status(first, options_.reports.require_expectations);
  }

 private:
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    names.reserve(scenarios_.size());
    for (const Scenario& scenario : scenarios_) names.push_back(scenario.name);
    return names;
  }

  [[nodiscard]] reports::ReportedRun reported(const std::string& program, const Played& played,
                                              std::size_t k) {
    const DriveConfig& drive = config_.drives[k].drive;
    const bool has_own_directory = !options_.out.empty() && scenarios_.size() > 1;
    const TraceOrigin trace{scenarios_[k].name, drive.drive.period_ns, drive.method().channels()};
    return {.program = program,
            .scenario = scenarios_[k],
            .plant = drive.plant,
            .configuration = played.configurations[k],
            .out = has_own_directory ? options_.out / scenarios_[k].name : options_.out,
            .trace = options_.no_trace ? std::nullopt : std::optional{trace},
            .is_expectation_required = options_.reports.require_expectations,
            .simulate = [this, k](TraceRecorder* recorder) { return result_of(k, recorder); }};
  }

  /// The drives run at once: each has its trace open when the last one starts the run.
  MilResult result_of(std::size_t k, TraceRecorder* trace) {
    traces_[k] = trace;
    const std::size_t next = k + 1;
    if (next < runs_.size()) {
      outcomes_[next] = outcome_of([this, next] { return runs_[next].result(); });
      if (outcomes_[next].problem) std::rethrow_exception(outcomes_[next].problem);
    } else {
      play();
    }
    return stages_[k].result();
  }

  void play() {
    std::vector<DriveIo<double>*> ends;
    ends.reserve(scenarios_.size());
    for (std::size_t k = 0; k < scenarios_.size(); ++k)
      ends.push_back(&stages_.emplace_back(scenarios_[k], config_.drives[k].drive.plant).io());
    const Scenario& scenario = scenarios_.front();
    run_.emplace(
        config_, options_.run, ends, [this] { return end(); },
        VirtualScenario{
            .name = scenario.name,
            .begin_ns = begin_ns(config_.drives.front()),
            .duration_ns = scenario.duration_ns,
            .torque = [this](std::size_t k, std::int64_t t_ns) { return stages_[k].torque(t_ns); },
            .observer = [this](std::size_t k, const Telemetry<double>& t) { stages_[k].period(t); }});
    for (std::size_t k = 0; k < stages_.size(); ++k) stages_[k].start(&run_->controller(k), traces_[k]);
    run_->run();
    run_->print_report(stdout);
  }

  /// Why the run need not go on; empty while it must.
  [[nodiscard]] std::string end() const {
    const bool is_over =
        std::ranges::all_of(stages_, [](const ObservedPowerStage& stage) { return stage.has_ended(); });
    return is_over || interruption_.signal() != 0 ? "the run is over" : "";
  }

  const ScenarioRunOptions& options_;
  const DrivesConfig& config_;
  std::vector<Scenario> scenarios_;
  reports::RunReports files_;
  reports::Interruption interruption_{};
  std::vector<reports::ReportedRun> runs_{};
  std::vector<TraceRecorder*> traces_;
  std::vector<Outcome<RunSummary>> outcomes_;
  std::deque<ObservedPowerStage> stages_{};  // each stays where it is
  std::optional<VirtualRun> run_{};
};

/// Observed by the plants in lockstep, one for each drive.
int run_in_lockstep(const std::string& program, const ScenarioRunOptions& options, const Played& played) {
  const Scenario& scenario = played.scenario.scenario;
  const std::int64_t begin = begin_ns(played.config.drives.front());
  const std::uint32_t mark = scenario_mark(scenario);
  std::deque<ScenarioCommands> commands;
  std::deque<PowerStage> stages;
  std::vector<DriveIo<double>*> ends;
  for (const EcuConfig& drive : played.config.drives) {
    commands.emplace_back(scenario);
    ends.push_back(&stages.emplace_back(drive).io());
  }
  const auto problem = [&stages] {
    for (const PowerStage& stage : stages) {
      if (std::string found = stage.problem(); !found.empty()) return found;
    }
    return std::string{};
  };
  VirtualRun run{
      played.config, options.run, ends, problem,
      VirtualScenario{
          .name = scenario.name,
          .begin_ns = begin,
          .duration_ns = scenario.duration_ns,
          .torque = [&](std::size_t k, std::int64_t t_ns) { return commands[k].reference(t_ns - begin); },
          .observer = [&](std::size_t k, const Telemetry<double>& t) { stages[k].report(t, begin, mark); }}};
  run.run();
  run.print_report(stdout);
  if (const std::string found = problem(); !found.empty()) return status_after(program.c_str(), found);
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
  switch (played.config.drives.front().power_stage_kind()) {
    case PowerStageKind::simulated:
      return ObservedRun{program, options, played}.run();
    case PowerStageKind::shared_memory:
    case PowerStageKind::udp:
    case PowerStageKind::own:  // refused
      break;
  }
  return run_in_lockstep(program, options, played);
}

}  // namespace sextant::ecu
