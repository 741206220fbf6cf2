#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sextant/sim/metric_list.hpp"

namespace sextant {

/// What a scenario demands of one metric; the bounds themselves are allowed.
struct Expectation {
  std::string metric{};         ///< a name of `metric_catalogue`
  std::optional<double> min{};  ///< in the metric's unit
  std::optional<double> max{};  ///< in the metric's unit

  /// Empty when the demand can be judged, else what is wrong.
  [[nodiscard]] std::string validate() const;
};

/// One judged expectation.
struct ExpectationResult {
  Expectation limit{};
  double value{};  ///< in the metric's unit; NaN if the run gave none
  bool pass{false};
};

/// Judges every expectation, in order. A NaN value fails, and so does a metric that does not exist.
[[nodiscard]] std::vector<ExpectationResult> evaluate(std::span<const Expectation> expectations,
                                                      const MetricList& metrics);

}  // namespace sextant
