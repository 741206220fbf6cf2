#include "sextant/run/summary_text.hpp"

#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace sextant {
namespace {

std::string missing_text(const MissingTorque& missing) {
  return fmt::format(
      "torque was asked, {:.4g} N·m in the mean, and {:.4g} N·m were made; the drive was in {} at last",
      missing.asked, missing.made, to_string(missing.state));
}

std::string departure_text(const CycleDeparture& departure) {
  return fmt::format(
      "the vehicle was up to {:.3g} km/h off its cycle, for {:.3g} s from {:.4g} s on; see [driver] and the "
      "torque that the drive has",
      3.6 * departure.farthest, in_seconds(departure.duration_ns), in_seconds(departure.from_ns));
}

std::string verdict_reason(const RunSummary& summary) {
  switch (summary.verdict()) {
    case Verdict::tripped:
      return fmt::format("the drive tripped with {} at {:.6f} s; see [protection] and [command]",
                         to_string(summary.faults.front().fault), in_seconds(summary.faults.front().t_ns));
    case Verdict::not_balanced:
      return fmt::format(
          "{:.2g} of the energy is unaccounted for, so that its figures do not count; "
          "choose a shorter step or tighter tolerances in [plant]",
          summary.metrics[Metric::energy_unaccounted]);
    case Verdict::interrupted:
      return fmt::format("interrupted at {:.6f} s", summary.metrics[Metric::simulated]);
    case Verdict::no_torque:
      return missing_text(summary.missing_torque.value_or(MissingTorque{}));
    case Verdict::not_followed:
      return departure_text(summary.cycle_departure.value_or(CycleDeparture{}));
    case Verdict::nothing_expected:
      if (!summary.expectations_required) return "";
      return "nothing is expected of the run: give its scenario limits in [expect], or a fault";
    default:
      if (!summary.expected_fault || !summary.faults.empty()) return "";
      return fmt::format("{} was expected and did not come", to_string(summary.expected_fault->fault));
  }
}

}  // namespace

double in_seconds(std::int64_t t_ns) noexcept {
  return double(t_ns) / 1e9;
}

std::string unit_text(std::string_view metric) {
  const std::optional<Metric> found = find_metric(metric);
  return found ? info(*found).unit : "";
}

std::string limit_text(const Expectation& e) {
  if (e.min && e.max) return fmt::format("{} … {}", *e.min, *e.max);
  if (e.min) return fmt::format("≥ {}", *e.min);
  if (e.max) return fmt::format("≤ {}", *e.max);
  return "";
}

std::string value_text(double x) {
  return std::isfinite(x) ? fmt::format("{:.5g}", x) : std::string{"-"};
}

std::string window_text(const TimeWindow& window) {
  const std::string end =
      window.to_ns == TimeWindow{}.to_ns ? "the end" : fmt::format("{} s", in_seconds(window.to_ns));
  return fmt::format("{} s to {}", in_seconds(window.from_ns), end);
}

std::string reason_text(const RunSummary& summary) {
  std::string text;
  for (const std::string& sentence : {summary.problem, verdict_reason(summary), summary.trace_error}) {
    if (sentence.empty()) continue;
    if (!text.empty()) text += '\n';
    text += sentence;
  }
  return text;
}

}  // namespace sextant
