#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "common/outcome.hpp"
#include "reports/run_reports.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario.hpp"
#include "sextant/run/summary.hpp"

namespace sextant::reports {

/// A run of a scenario whose result is kept, printed and reported, whichever program makes it.
struct ReportedRun {
  /// The run; `trace` is null where none is kept.
  using Simulate = std::function<MilResult(TraceRecorder* trace)>;

  std::string program;                  ///< its name, for messages
  const Scenario& scenario;             ///< not owned
  SimulatedPowerStageParameters plant;  ///< of the run
  std::string configuration;            ///< in force, as JSON; empty where there is none
  std::filesystem::path out;            ///< directory of its result; empty: none is kept
  std::optional<TraceOrigin> trace{};   ///< empty: the result has no trace
  bool is_expectation_required{false};  ///< a run of which nothing is expected is a failure
  Simulate simulate;

  /// Runs and writes the result; beside other runs too.
  [[nodiscard]] RunSummary result() const;

  /// Prints the table of a result and adds it to the reports; where result() threw, adds its sentence to them
  /// and throws on.
  [[nodiscard]] Verdict report(const Outcome<RunSummary>& outcome, RunReports& reports) const;

  /// Both, one after the other.
  [[nodiscard]] Verdict run(RunReports& reports) const;
};

}  // namespace sextant::reports
