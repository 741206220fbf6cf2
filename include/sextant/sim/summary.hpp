#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "sextant/sim/expectation.hpp"
#include "sextant/sim/metric_list.hpp"

namespace sextant {

/// How a run turned out.
struct RunSummary {
  std::string scenario{};
  MetricList metrics{};
  std::vector<ExpectationResult> expectations{};

  /// True when every expectation holds; also when there is none.
  [[nodiscard]] bool passed() const noexcept;
};

/// The summary as JSON: `scenario`, `metrics` (name to value, null where the run gave none) and `expect`, a
/// list of `metric`, `limit` (an object with `min`, `max` or both), `value` and `pass`.
[[nodiscard]] std::string to_json(const RunSummary& summary);

/// Writes the JSON to a file so that a reader finds the old file or the new one, never a part.
/// Throws std::runtime_error with file and reason.
void write_summary(const RunSummary& summary, const std::filesystem::path& file);

/// The summary as an aligned table for people, with ANSI colours if wanted.
[[nodiscard]] std::string format_summary(const RunSummary& summary, bool colour);

/// Prints the table; in colour if `out` is a terminal and the environment has no NO_COLOR.
void print_summary(const RunSummary& summary, std::FILE* out);

}  // namespace sextant
