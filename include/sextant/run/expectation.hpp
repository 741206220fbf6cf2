#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sextant/core/fault.hpp"
#include "sextant/run/metric_list.hpp"

namespace sextant {

/// A stretch of a run, both ends included.
struct TimeWindow {
  std::int64_t from_ns{0};                                       ///< [ns]
  std::int64_t to_ns{std::numeric_limits<std::int64_t>::max()};  ///< [ns]

  [[nodiscard]] constexpr bool contains(std::int64_t t_ns) const noexcept {
    return t_ns >= from_ns && t_ns <= to_ns;
  }
};

/// Bounds of a scenario on one metric, both included.
struct Expectation {
  std::string metric{};         ///< a name of `metric_catalogue`
  std::optional<double> min{};  ///< in the metric's unit
  std::optional<double> max{};  ///< in the metric's unit

  /// Empty when the bounds can be evaluated, else what is wrong.
  [[nodiscard]] std::string validate() const;
};

/// One evaluated expectation.
struct ExpectationResult {
  Expectation limit{};
  double value{};  ///< in the metric's unit; NaN if the run gave none
  bool pass{false};
  std::optional<TimeWindow> window{};  ///< over which the metric was taken, where it is not the run's own
};

/// Limits that hold over a window of their own.
struct WindowExpectation {
  TimeWindow window{};
  std::vector<Expectation> limits{};
};

/// A trip that a scenario expects.
struct FaultExpectation {
  Fault fault{};        ///< that latches first
  TimeWindow window{};  ///< in which it latches
};

/// Evaluates every expectation, in order. A NaN value fails, and so does a metric that does not exist.
[[nodiscard]] std::vector<ExpectationResult> evaluate(std::span<const Expectation> expectations,
                                                      const MetricList& metrics);

}  // namespace sextant
