#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/sim/metric_list.hpp"

namespace sextant {

/// Over which part of a run its metrics are taken.
struct MetricsParameters {
  std::int64_t from_ns{0};                                       ///< first instant of the steady window [ns]
  std::int64_t to_ns{std::numeric_limits<std::int64_t>::max()};  ///< last instant of it, included [ns]
  std::optional<std::int64_t> step_ns{};                         ///< instant of the reference step [ns]

  [[nodiscard]] constexpr const char* validate() const noexcept {
    if (from_ns < 0) return "the window must not begin before 0";
    if (to_ns <= from_ns) return "the window must end after it begins";
    if (step_ns && *step_ns < 0) return "the step must not be before 0";
    return nullptr;
  }
};

/// The true state of drive and plant at one instant; the plant's values, not the estimator's.
struct MetricsSample {
  std::int64_t t_ns{};         ///< from the beginning of the run [ns]
  double torque_reference{};   ///< [N·m]
  double torque{};             ///< air-gap torque [N·m]
  SpaceVector<> psi_s{};       ///< stator flux linkage, stationary frame [Wb]
  SpaceVector<> i_s{};         ///< stator current, stationary frame [A]
  double omega_m{};            ///< mechanical speed [rad/s]
  SwitchState switch_state{};  ///< in force from t_ns on
};

/// Reduces a run to its metrics, in constant memory, from one sample per control period.
///
/// - Torque ripple and bias are those of the error T − T_ref in the window, so that a moving reference does
///   not count as ripple.
/// - The response time runs from `step_ns` to the first sample whose torque has covered 95 % of the way from
///   the reference before the step to the reference at its first sample. A reference before the first sample
///   counts as zero.
/// - The switching frequency counts turn-ons of each leg's upper switch, which is the switching frequency of
///   one device, and averages the legs.
/// - Current THD is that of the space vector in the frame of the stator flux. There the fundamental is
///   constant, I_1 = mean(i), at any and even at changing speed, and
///     THD = sqrt(mean|i|² − |mean i|²) / |mean i|.
///   A Fourier analysis would need a whole number of fundamental periods and a fixed frequency; DTC under
///   load steps has neither, nor a carrier to synchronise with. Ripple of the flux angle itself is thereby
///   part of the frame and does not count. For sinusoidal flux and balanced harmonics it is the phase
///   currents' THD.
///
/// Means and variances use Welford's recurrence (Technometrics 4(3), 1962), which does not cancel.
/// A sample that is not finite makes every metric NaN: a broken run must not look like a good one.
class MetricsAccumulator {
 public:
  /// Throws std::runtime_error with the sentence of `validate()`.
  explicit MetricsAccumulator(const MetricsParameters& parameters);

  /// Adds a sample; times must not decrease.
  void add(const MetricsSample& sample) noexcept;

  /// Tells of a switching edge between two samples, for patterns of several segments and event-exact runs.
  /// `add` does this by itself for its sample's state.
  void commutate(std::int64_t t_ns, SwitchState state) noexcept;

  /// The metrics so far. Those of the simulation's speed are the runner's to fill in.
  [[nodiscard]] MetricList metrics() const noexcept;

 private:
  struct RunningMean {
    double mean{};
    double sum_of_squares{};  // of the deviations from the mean
    double min{std::numeric_limits<double>::infinity()};
    double max{-std::numeric_limits<double>::infinity()};

    void add(double x, double weight) noexcept;  // weight: one over the number of values, x included
  };

  void add_to_window(const MetricsSample& sample) noexcept;
  void watch_step(const MetricsSample& sample) noexcept;
  [[nodiscard]] double switching_frequency() const noexcept;

  MetricsParameters parameters_;
  RunningMean torque_error_{};
  RunningMean flux_{};
  RunningMean i_flux_{};        // current along the stator flux [A]
  RunningMean i_quadrature_{};  // current 90 electrical degrees ahead of it [A]
  std::int64_t samples_{0};     // in the window
  std::int64_t first_ns_{};     // first and last sample in the window
  std::int64_t last_ns_{};
  std::int64_t turn_ons_{0};  // of the three upper switches
  std::optional<SwitchState> switch_state_{};
  double reference_before_{0};
  std::optional<double> reference_after_{};
  std::optional<double> response_ms_{};
  double peak_current_{0};
  bool any_{false};
  bool finite_{true};
};

}  // namespace sextant
