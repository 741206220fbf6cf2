#include "sextant/mil/mil_program.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/command_line.hpp"
#include "common/exit_status.hpp"
#include "common/in_order.hpp"
#include "common/outcome.hpp"
#include "common/program.hpp"
#include "mil/progress_bar.hpp"
#include "reports/interruption.hpp"
#include "reports/report_options.hpp"
#include "reports/reported_run.hpp"
#include "reports/run_reports.hpp"
#include "reports/status_table.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "sextant/recording/trace_threads.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/verdict.hpp"

namespace {

struct Options {
  std::vector<std::string> scenarios{};
  std::filesystem::path out{"out"};
  std::vector<std::string> overrides{};
  std::optional<std::string> integrator{};
  std::size_t jobs{1};
  bool print_config{false};
  bool no_trace{false};
  sextant::reports::ReportOptions reports{};
};

constexpr double most_jobs = 256;

/// For the name of the program and the statuses of its runs.
constexpr const char* notes = R"(Examples:
  {0} configs/scenarios/constant_torque.toml
  {0} configs/scenarios/*.toml --integrator fixed
  {0} configs/scenarios/reversal.toml --set control.dtc.torque_band_upper_nm=0.5 --out out/half_band
  {0} configs/scenarios/reversal.toml --print-config
  {0} configs/scenarios/*.toml --jobs 4 --no-trace --junit out/junit.xml --summary-markdown "$GITHUB_STEP_SUMMARY"
Writes DIR/<scenario>/trace.h5 and DIR/<scenario>/summary.json (straight into DIR for one scenario), in the
place of those of an earlier run. SIGINT and SIGTERM close the traces and write the summaries
of what runs.
Exit status, by the verdict of the run; of several runs, the one of them that stands first here:
{1})";

/// The texts must outlive it.
sextant::CommandLine command_line(const std::string& program, const std::string& help, Options& options) {
  sextant::CommandLine line{
      program.c_str(),
      "Sextant: runs scenarios of the drive with its model in the loop.",
      help.c_str(),
      {{.name = "scenarios",
        .value = &options.scenarios,
        .what = "scenario files",
        .type_name = "SCENARIO.toml",
        .required = true},
       {.name = "--out", .value = &options.out, .what = "directory for traces and summaries"},
       {.name = "--set", .value = &options.overrides, .what = "key=value, overrides the files"},
       {.name = "--integrator",
        .value = &options.integrator,
        .what = "how the plant is integrated",
        .choices = {"cvode", "fixed", "exact", "erk"}},
       {.name = "--jobs",
        .value = &options.jobs,
        .what = "scenarios at a time",
        .type_name = "N",
        .least = 1,
        .most = most_jobs},
       {.name = "--no-trace", .value = &options.no_trace, .what = "write the summary only"},
       {.name = "--print-config",
        .value = &options.print_config,
        .what = "print the configuration in force and exit"}}};
  const std::vector<sextant::Option> reports = sextant::reports::report_options(options.reports);
  line.options.insert(line.options.end() - 1, reports.begin(), reports.end());
  return line;
}

template <class PowerStage>
sextant::MilResult run_sampled(const sextant::ScenarioConfig& config, sextant::TraceRecorder* trace,
                               const sextant::MilRunner::Progress& progress) {
  using namespace sextant;
  PowerStage power_stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  MilRunner runner{drive, power_stage.io(), config.drive.drive.period_ns, controller.get()};
  return runner.run(config.scenario, trace, progress);
}

sextant::MilResult run_scenario(const sextant::ScenarioConfig& config, sextant::TraceRecorder* trace,
                                const sextant::MilRunner::Progress& progress) {
  using namespace sextant;
  if (config.mode == ScenarioMode::sampled) {
    return with_appended(config.drive.plant, [&]<class Appended>(std::type_identity<Appended>) {
      return run_sampled<MeteredPowerStageOf<Appended>>(config, trace, progress);
    });
  }
  return EventExactRunner{config.event_exact_runner()}.run(config.scenario, trace, progress);
}

/// Description of the run in its trace; an event-exact one has no control period.
sextant::TraceOrigin origin(const sextant::ScenarioConfig& config) {
  const bool sampled = config.mode == sextant::ScenarioMode::sampled;
  return {config.scenario.name,
          sampled ? std::optional<std::int64_t>{config.drive.drive.period_ns} : std::nullopt,
          config.drive.method().channels()};
}

/// Says on standard error where a run takes minutes for a simulated second.
void note_slow_run(const std::string& program, const sextant::ScenarioConfig& config) {
  using namespace sextant;
  if (config.mode != ScenarioMode::event_exact) return;
  const EventExactRunner::Parameters run = config.event_exact_runner();
  if (run.control.torque_comparator.reading != ComparatorReading::memoryless) return;
  fmt::print(
      stderr,
      "{}: {}: control.dtc.comparator_reading = \"memoryless\" switches at each end of "
      "event_exact.minimum_dwell_ns = {}, up to {:.3g} times a simulated second, which takes minutes; a "
      "longer dwell takes less\n",
      program, config.scenario.name, run.event_exact.minimum_dwell_ns,
      1e9 / double(std::max<std::int64_t>(1, run.event_exact.minimum_dwell_ns)));
}

/// Each run writes its trace in the thread that makes it.
void check_jobs(const Options& options) {
  const bool has_threads = std::min(options.jobs, options.scenarios.size()) > 1;
  if (!has_threads || options.no_trace || sextant::may_write_traces_from_threads()) return;
  throw std::runtime_error(
      fmt::format("--jobs {}: the HDF5 library of this machine cannot write from several threads: give "
                  "--no-trace, or leave --jobs out",
                  options.jobs));
}

/// Results are kept under the scenarios' names: each needs one of its own, and one that stays in --out.
void check_names(const std::vector<std::string>& files, const std::vector<sextant::ScenarioConfig>& configs) {
  for (std::size_t i = 0; i < configs.size(); ++i) {
    const std::string& name = configs[i].scenario.name;
    if (name == "." || name == ".." || name.find('/') != std::string::npos) {
      throw std::runtime_error(files[i] + ": the name \"" + name +
                               "\" cannot be that of a directory: choose one without \"/\"");
    }
    for (std::size_t before = 0; before < i; ++before) {
      if (configs[before].scenario.name != name) continue;
      throw std::runtime_error(files[i] + ": the name \"" + name + "\" is taken by " + files[before] +
                               ", whose results would be overwritten: choose another");
    }
  }
}

std::vector<std::string> names_of(const std::vector<sextant::ScenarioConfig>& configs) {
  std::vector<std::string> names;
  names.reserve(configs.size());
  for (const sextant::ScenarioConfig& config : configs) names.push_back(config.scenario.name);
  return names;
}

/// One scenario of several.
sextant::reports::ReportedRun reported_run(const std::string& program, const Options& options,
                                           const sextant::ScenarioConfig& config,
                                           const sextant::reports::Interruption& interruption) {
  using namespace sextant;
  const auto simulate = [&](TraceRecorder* trace) {
    note_slow_run(program, config);
    std::optional<mil::ProgressBar> bar;
    if (std::min(options.jobs, options.scenarios.size()) == 1) bar.emplace(config.scenario.name, stderr);
    MilResult result = run_scenario(config, trace, [&](double fraction) {
      if (bar) bar->show(fraction);
      return interruption.signal() == 0;
    });
    if (bar) bar->finish();
    return result;
  };
  return {.program = program,
          .scenario = config.scenario,
          .plant = config.drive.plant,
          .configuration = config_json(config),
          .out = options.scenarios.size() == 1 ? options.out : options.out / config.scenario.name,
          .trace = options.no_trace ? std::nullopt : std::optional{origin(config)},
          .is_expectation_required = options.reports.require_expectations,
          .simulate = simulate};
}

/// Runs them, so many at a time. After an interruption, and after one that could not run, no further one
/// begins; those that have begun are reported.
int run_all(const std::string& program, const Options& options,
            const std::vector<sextant::ScenarioConfig>& configs) {
  using namespace sextant;
  reports::RunReports files{options.reports, names_of(configs), program};
  const reports::Interruption interruption;
  std::vector<reports::ReportedRun> runs;
  runs.reserve(configs.size());
  for (const ScenarioConfig& config : configs)
    runs.push_back(reported_run(program, options, config, interruption));

  std::atomic<bool> has_failed{false};
  const auto work = [&](std::size_t k) {
    try {
      return runs[k].result();
    } catch (...) {
      has_failed = true;
      throw;
    }
  };
  Verdict first = Verdict::pass;  // in the order of the verdicts
  std::exception_ptr problem;
  auto run = runs.cbegin();
  const auto report = [&](const Outcome<RunSummary>& outcome) {
    try {
      first = std::min(first, (run++)->report(outcome, files));
    } catch (...) {
      if (!problem) problem = std::current_exception();
    }
  };
  in_order(
      runs.size(), options.jobs, work, [&] { return interruption.signal() == 0 && !has_failed; }, report);
  if (problem) std::rethrow_exception(problem);
  if (interruption.signal() != 0) return interruption.status();
  return exit_status(first, options.reports.require_expectations);
}

/// The names of the scenarios; those behind `read` have the name of their file.
std::vector<std::string> all_names(const Options& options, const std::vector<sextant::ScenarioConfig>& read) {
  std::vector<std::string> names = names_of(read);
  for (std::size_t k = names.size(); k < options.scenarios.size(); ++k)
    names.push_back(std::filesystem::path{options.scenarios[k]}.stem().string());
  return names;
}

/// All files are read before anything runs: a mistake in the last one must not cost the first its time.
std::vector<sextant::ScenarioConfig> read_all(const std::string& program, const Options& options,
                                              const sextant::ControlMethods& own) {
  std::vector<sextant::ScenarioConfig> configs;
  configs.reserve(options.scenarios.size());
  try {
    if (!options.print_config) check_jobs(options);
    for (const std::string& file : options.scenarios)
      configs.push_back(sextant::load_scenario_config(file, options.overrides, own));
    if (!options.print_config) check_names(options.scenarios, configs);
  } catch (const std::exception& problem) {
    if (!options.print_config)
      report_not_started(program, options.reports, all_names(options, configs), problem.what());
    throw;
  }
  return configs;
}

int run(const std::string& program, Options options, const sextant::ControlMethods& own) {
  if (options.integrator) options.overrides.push_back("plant.integrator=" + *options.integrator);
  const std::vector<sextant::ScenarioConfig> configs = read_all(program, options, own);
  if (!options.print_config) return run_all(program, options, configs);
  for (const sextant::ScenarioConfig& config : configs)
    std::fputs(sextant::print_config(config).c_str(), stdout);
  return sextant::ExitStatus::done;
}

}  // namespace

int sextant::mil_program(int argc, char** argv, const ControlMethods& own) {
  Options options;
  const std::string program = program_name(argc, argv, "sextant-mil");
  const std::string help = fmt::format(notes, program, sextant::reports::verdict_status_table());
  CommandLine line = command_line(program, help, options);
  line.refused = [&](const std::string& why) {
    reports::report_not_started(program, options.reports, all_names(options, {}), why);
  };
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return run_program(program.c_str(), [&] { return run(program, options, own); });
}
