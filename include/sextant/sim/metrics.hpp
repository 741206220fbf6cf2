#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/sim/energy_account.hpp"
#include "sextant/sim/metric_list.hpp"
#include "sextant/sim/metrics_sample.hpp"
#include "sextant/sim/moments.hpp"
#include "sextant/sim/step_response.hpp"

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

/// Reduces a run to its metrics, in constant memory: a sampled run from one sample per control period
/// (`add`), an event-exact one from the segments between its instants (`add_segment`). A run uses one of the
/// two.
///
/// - Torque ripple and bias are those of the error T − T_ref in the window, so that a moving reference does
///   not count as ripple.
/// - The response time runs from `step_ns` until the torque has covered 95 % of the way from the reference
///   before the step to the reference at the step (`StepResponse`).
/// - The switching frequency counts turn-ons of each leg's upper switch, which is the switching frequency of
///   one device, and averages the legs.
/// - Pulses of the torque comparator are told by `pulse`. A sampled run has no such event: there the state
///   that goes from a zero vector to an active one is the pulse.
/// - Current THD is that of the space vector in the frame of the stator flux. There the fundamental is
///   constant, I_1 = mean(i), at any and even at changing speed, and
///     THD = sqrt(mean|i|² − |mean i|²) / |mean i|.
///   A Fourier analysis would need a whole number of fundamental periods and a fixed frequency; DTC under
///   load steps has neither, nor a carrier to synchronise with. Ripple of the flux angle itself is thereby
///   part of the frame and does not count. For sinusoidal flux and balanced harmonics it is the phase
///   currents' THD.
/// - The energies from and to the link are the integrals of the positive and of the negative part of its
///   power: in a sampled run of its mean over each control period, in an event-exact run of its instantaneous
///   value, which is why only their difference compares between the two.
///
/// A sample that is not finite makes every metric NaN: a broken run must not look like a good one.
class MetricsAccumulator {
 public:
  /// Throws std::runtime_error with the sentence of `validate()`.
  explicit MetricsAccumulator(const MetricsParameters& parameters);

  /// Adds a sample; times must not decrease.
  void add(const MetricsSample& sample) noexcept;

  /// Adds the time between two instants. Torque, reference, flux magnitude, current in the flux frame, speed
  /// and link power run linearly from `before` to `after`, and weigh by their duration; the window cuts a
  /// segment where its end lies. What jumps, as a reference does, jumps between the `after` of one segment
  /// and the `before` of the next. A segment without length has no weight.
  void add_segment(const MetricsSample& before, const MetricsSample& after) noexcept;

  /// Tells of a switching edge between two samples, for patterns of several segments and event-exact runs.
  /// `add` does this by itself for its sample's state.
  void commutate(std::int64_t t_ns, SwitchState state) noexcept;

  /// Tells of the beginning of a torque comparator's pulse in an event-exact run.
  void pulse(std::int64_t t_ns) noexcept;

  /// The metrics so far. Those of the simulation's speed and of the minimum dwell are the
  /// runner's to fill in.
  [[nodiscard]] MetricList metrics() const noexcept;

 private:
  enum Quantity : Eigen::Index { torque_error, flux, i_flux, i_quadrature, quantities };

  struct WindowValues {
    Moments<quantities>::Values values{};  // current along the stator flux and 90 electrical degrees ahead
    double speed_error{};
    DrivePowers powers{};
  };

  [[nodiscard]] static WindowValues window_values(const MetricsSample& sample) noexcept;
  [[nodiscard]] static WindowValues between(const WindowValues& a, const WindowValues& b,
                                            double share) noexcept;
  void note_current(SpaceVector<> i_s) noexcept;
  void add_to_window(const MetricsSample& sample) noexcept;
  void add_to_window(const WindowValues& a, const WindowValues& b, double seconds) noexcept;
  void fill_window_metrics(MetricList& m) const noexcept;

  MetricsParameters parameters_;
  StepResponse response_;
  Moments<quantities> moments_{};
  double speed_error_squares_{0};
  EnergyAccount energy_{};
  std::int64_t first_ns_{};  // first and last sample in the window
  std::int64_t last_ns_{};
  DrivePowers last_powers_{};
  std::int64_t turn_ons_{0};     // of the three upper switches
  std::int64_t activations_{0};  // zero vectors left for active ones
  std::int64_t pulses_{0};
  std::optional<SwitchState> switch_state_{};
  double peak_current_{0};
  bool event_exact_{false};
  bool any_{false};
  bool finite_{true};
};

}  // namespace sextant
