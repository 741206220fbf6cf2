#pragma once

#include <cstdint>
#include <optional>

#include "sextant/run/metrics_sample.hpp"

namespace sextant {

/// Time from a step of the torque reference until the torque has covered 95 % of it, from the reference
/// before the step to the reference at the step. A reference before the first sample counts as zero.
class StepResponse {
 public:
  /// Without an instant there is nothing to watch.
  explicit StepResponse(std::optional<std::int64_t> step_ns) noexcept
      : step_ns_{step_ns.value_or(0)}, watching_{step_ns.has_value()} {}

  /// False once the torque has responded or the window for a response has ended.
  [[nodiscard]] bool watching() const noexcept { return watching_; }

  /// Torque and reference run linearly from `before` to `after`; the response is that of the line. The
  /// reference steps between two segments, where it jumps within a picosecond of the step, or first jumps
  /// after it: a sampled drive takes a step over at its next control period.
  void add_segment(const MetricsSample& before, const MetricsSample& after) noexcept {
    const double begin_ns = before.since(step_ns_);
    const double end_ns = after.since(step_ns_);
    if (end_ns <= rounding_ns) {
      reference_before_ = after.torque_reference;
    } else if (begin_ns < -rounding_ns) {
      reference_before_ = before.torque_reference;
      watching_ = before.torque_reference == after.torque_reference;  // along a line there is no step
    } else {
      respond(begin_ns, end_ns - begin_ns, before.torque_reference, before.torque, after.torque);
    }
  }

  /// Empty while the torque has not responded, or there was no step. [ms]
  [[nodiscard]] std::optional<double> time_ms() const noexcept { return time_ms_; }

 private:
  static constexpr double response_share = 0.95;
  static constexpr double rounding_ns = 1e-3;  // of instants that are sums of many durations

  // Torque goes from `torque` at begin_ns to `torque_end` in duration_ns.
  void respond(double begin_ns, double duration_ns, double reference, double torque,
               double torque_end) noexcept {
    if (!reference_after_) reference_after_ = reference;
    const double step = *reference_after_ - reference_before_;
    if (step == 0) return;
    const double covered = (torque - reference_before_) / step;
    const double covered_end = (torque_end - reference_before_) / step;
    if (covered < response_share && covered_end < response_share) return;
    const double wait =
        covered < response_share ? (response_share - covered) / (covered_end - covered) * duration_ns : 0;
    time_ms_ = (begin_ns + wait) * 1e-6;
    watching_ = false;
  }

  std::int64_t step_ns_;
  bool watching_;
  double reference_before_{0};
  std::optional<double> reference_after_{};
  std::optional<double> time_ms_{};
};

}  // namespace sextant
