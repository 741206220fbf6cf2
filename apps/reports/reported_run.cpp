#include "reports/reported_run.hpp"

#include <cstdio>
#include <exception>
#include <sstream>

#include <fmt/format.h>

#include "common/build_commit.hpp"
#include "reports/result_directory.hpp"
#include "sextant/run/summary_text.hpp"

namespace sextant::reports {
namespace {

/// A further problem of a run, in a sentence; empty without one.
std::string problem_of(const MilResult& result, const SimulatedPowerStageParameters& plant) {
  if (!result.events_ended) {
    return fmt::format(
        "the events do not end at {:.6f} s; a longer event_exact.minimum_dwell_ns bounds them, "
        "event_exact.max_events allows more",
        result.metrics[Metric::simulated]);
  }
  if (!result.plant_reachable) {
    return "the plant's stator flux left what the DC link can feed, or a link with capacitance fell below "
           "zero: choose smaller steps or tolerances in [plant], another plant.integrator, or a source of "
           "[plant.link] that delivers the power";
  }
  if (result.plant_healthy) return {};
  const bool may_be_stiff = plant.link.acts() || plant.driveline.acts();
  return std::string{"the integrator of the plant failed; the run ends there"} +
         (may_be_stiff ? ": where [plant.link] or [plant.driveline] move much faster than the machine, "
                         "plant.cvode.method = \"bdf\" follows them"
                       : "");
}

/// Prints on standard error why a run did not pass, where the table does not show it.
void print_reason(const std::string& program, const RunSummary& summary) {
  std::istringstream lines{reason_text(summary)};
  for (std::string line; std::getline(lines, line);)
    std::fprintf(stderr, "%s: %s: %s\n", program.c_str(), summary.scenario.c_str(), line.c_str());
}

}  // namespace

RunSummary ReportedRun::result() const {
  std::optional<ResultDirectory> directory;
  if (!out.empty()) directory.emplace(out, program);
  std::optional<TraceRecorder> recorder;
  // The summary's reason has the error of the trace.
  if (directory && trace)
    recorder.emplace(directory->trace(), scenario.trace, *trace, [](const std::string&) {});

  const MilResult result = simulate(recorder ? &*recorder : nullptr);
  if (recorder) recorder->close();

  RunSummary summary = summarise(scenario, result);
  summary.trace_error = recorder ? recorder->error() : "";
  summary.expectations_required = is_expectation_required;
  summary.problem = problem_of(result, plant);
  summary.configuration = configuration;
  summary.version = SEXTANT_VERSION;
  summary.commit = build_commit;
  if (directory) write_summary(summary, directory->summary());
  return summary;
}

Verdict ReportedRun::report(const Outcome<RunSummary>& outcome, RunReports& reports) const {
  if (!outcome.result) {
    try {
      std::rethrow_exception(outcome.problem);
    } catch (const std::exception& problem) {
      reports.add_error(scenario.name, problem.what());
      throw;
    }
  }
  const RunSummary& done = *outcome.result;
  print_summary(done, stdout);
  print_reason(program, done);
  reports.add(done);
  return done.verdict();
}

Verdict ReportedRun::run(RunReports& reports) const {
  return report(outcome_of([this] { return result(); }), reports);
}

}  // namespace sextant::reports
