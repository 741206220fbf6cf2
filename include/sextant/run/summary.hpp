#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sextant/run/expectation.hpp"
#include "sextant/run/metric_list.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario.hpp"
#include "sextant/run/verdict.hpp"

namespace sextant {

/// How a run turned out.
struct RunSummary {
  /// Share of the energy that may be unaccounted for in a run that counts. [-]
  static constexpr double largest_unaccounted = 1e-4;

  std::string scenario{};
  MetricList metrics{};
  std::vector<ExpectationResult> expectations{};
  std::vector<LatchedFault> faults{};  ///< in the order in which they latched
  std::optional<FaultExpectation> expected_fault{};
  std::optional<MissingTorque> missing_torque{};    ///< asked and not made
  std::optional<CycleDeparture> cycle_departure{};  ///< of a vehicle that did not follow its cycle
  bool expectations_required{false};                ///< a run of which nothing is expected is a failure
  bool stopped{false};                              ///< ended from outside before its time
  bool plant_healthy{true};                         ///< false: the plant's integration gave up
  std::string trace_error{};                        ///< why the trace ends early; empty when it does not
  std::string problem{};                            ///< a further problem of the run, in a sentence
  std::string configuration{};                      ///< in force, as JSON; empty where there is none
  std::string version{};                            ///< of the program
  std::string commit{};                             ///< that the program was built from

  /// True when every expectation holds; also when there is none.
  [[nodiscard]] bool passed() const noexcept;

  /// True when no fault was expected and none came, or when the first one is the one that was expected, in
  /// its window. One of the hand-shake, before time zero, counts as one at zero.
  [[nodiscard]] bool faults_as_expected() const noexcept;

  /// True where a limit or a fault is expected.
  [[nodiscard]] bool expects_something() const noexcept {
    return !expectations.empty() || expected_fault.has_value();
  }

  [[nodiscard]] Verdict verdict() const noexcept;

  /// Exit status of a program with this run alone; `interrupted`: without the signal.
  [[nodiscard]] int status() const noexcept { return exit_status(verdict(), expectations_required); }
};

/// What is known of a run once it has ended; trace, configuration and program are the caller's to add.
[[nodiscard]] RunSummary summarise(const Scenario& scenario, const MilResult& result);

/// The summary as JSON: `scenario`, `verdict`, `metrics` (name to value, null where the run gave none),
/// `expect`, a list of `metric`, `limit` (an object with `min`, `max` or both), `value`, `pass` and, for a
/// limit over a window of its own, `window` (`from_s`, `to_s`); `faults`, a list of `fault` and `t_s`;
/// `expected_fault`, null or an object with `fault`, `from_s`, `to_s` and `pass`; `configuration`, dotted
/// keys to values; `version` and `commit`.
[[nodiscard]] std::string to_json(const RunSummary& summary);

/// Writes the JSON to a file so that a reader finds the old file or the new one, never a part.
/// Throws std::runtime_error with file and reason.
void write_summary(const RunSummary& summary, const std::filesystem::path& file);

/// The scenario of an earlier run, from its summary file. Empty where the file is no summary.
[[nodiscard]] std::optional<std::string> scenario_of_summary(const std::filesystem::path& file);

/// The summary as an aligned table for people, with ANSI colours if wanted.
[[nodiscard]] std::string format_summary(const RunSummary& summary, bool colour);

/// Prints the table; in colour if `out` is a terminal and the environment has no NO_COLOR.
void print_summary(const RunSummary& summary, std::FILE* out);

}  // namespace sextant
