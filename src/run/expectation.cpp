#include "sextant/run/expectation.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace sextant {
namespace {

std::string known_metrics() {
  std::string names;
  for (const MetricInfo& m : metric_catalogue) fmt::format_to(std::back_inserter(names), " {}", m.name);
  return names;
}

}  // namespace

std::string Expectation::validate() const {
  if (!find_metric(metric))
    return fmt::format("there is no metric '{}'; known are{}", metric, known_metrics());
  if (!min && !max) return fmt::format("{}: give min, max or both", metric);
  if ((min && !std::isfinite(*min)) || (max && !std::isfinite(*max))) {
    return fmt::format("{}: a limit must be finite", metric);
  }
  if (min && max && *min > *max) return fmt::format("{}: min {} is above max {}", metric, *min, *max);
  return {};
}

std::vector<ExpectationResult> evaluate(std::span<const Expectation> expectations,
                                        const MetricList& metrics) {
  std::vector<ExpectationResult> results;
  results.reserve(expectations.size());
  for (const Expectation& e : expectations) {
    const auto metric = find_metric(e.metric);
    const double value = metric ? metrics[*metric] : std::numeric_limits<double>::quiet_NaN();
    const bool pass = !std::isnan(value) && (!e.min || value >= *e.min) && (!e.max || value <= *e.max);
    results.push_back({.limit = e, .value = value, .pass = pass});
  }
  return results;
}

}  // namespace sextant
