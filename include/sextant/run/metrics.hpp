#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/plant/thermal_parameters.hpp"
#include "sextant/recording/energy_account.hpp"
#include "sextant/run/metric_list.hpp"
#include "sextant/run/metrics_sample.hpp"
#include "sextant/run/moments.hpp"
#include "sextant/run/steady_current.hpp"
#include "sextant/run/step_response.hpp"
#include "sextant/run/torque_deviation.hpp"

namespace sextant {

/// Over which part of a run its metrics are taken.
struct MetricsParameters {
  std::int64_t from_ns{0};                                       ///< first instant of the steady window [ns]
  std::int64_t to_ns{std::numeric_limits<std::int64_t>::max()};  ///< last instant of it, included [ns]
  std::optional<std::int64_t> step_ns{};                         ///< instant of the reference step [ns]
  double torque_tolerance{2};  ///< least one of `TorqueDeviation`, of a drive of 150 N·m [N·m]

  [[nodiscard]] constexpr const char* validate() const noexcept {
    if (from_ns < 0) return "the window must not begin before 0";
    if (to_ns <= from_ns) return "the window must end after it begins";
    if (step_ns && *step_ns < 0) return "the step must not be before 0";
    if (!(torque_tolerance > 0)) return "the tolerance of the torque must be above zero";
    return nullptr;
  }
};

/// Reduces a run to its metrics, in constant memory, from the segments between its instants: a switching
/// state, a corner of the load or a control period begins a new one. The same metrics serve sampled and
/// event-exact runs.
///
/// - Torque ripple and bias are those of the error T − T_ref in the window, so that a moving reference does
///   not count as ripple. Between its ends a segment is a straight line, and weighs by its duration.
/// - The response time runs from `step_ns` until the torque has covered 95 % of the way from the reference
///   before the step to the reference at the step (`StepResponse`).
/// - The deviation from the attainable command (`TorqueDeviation`) is that of a sampled run, whose control
///   periods `begin_period` gives.
/// - The switching frequency counts turn-ons of each leg's upper switch, which is the switching frequency of
///   one device, and averages the legs.
/// - A pulse of the torque comparator begins where its output becomes +1 or −1 (`pulse`). A run whose
///   controller has no such comparator calls `has_no_pulses`.
/// - Current THD is that of the space vector in the frame of the stator flux. There the fundamental is
///   constant, I_1 = mean(i), at any and even at changing speed, and
///     THD = sqrt(mean|i|² − |mean i|²) / |mean i|.
///   A Fourier analysis would need a whole number of fundamental periods and a fixed frequency; DTC under
///   load steps has neither, nor a carrier to synchronise with. Ripple of the flux angle itself is thereby
///   part of the frame and does not count. For sinusoidal flux and balanced harmonics it is the phase
///   currents' THD. Where the torque moves there is no constant fundamental, and no THD is given: the
///   reference must be constant throughout the window and for 20 ms before it, every leg must be driven, and
///   the fundamental must stay within 10 % (`SteadyCurrent`).
/// - Energies are the differences of the plant's own meter. Those from and to the link are the integrals of
///   the positive and of the negative part of the link's instantaneous power (`EnergyAccount`).
/// - A temperature is the highest in the window.
/// - What is unaccounted for is the balance of the whole run, window or not.
///
/// A sample that is not finite makes every metric NaN: a broken run must not pass.
class MetricsAccumulator {
 public:
  /// Throws std::runtime_error with the sentence of `validate()`.
  explicit MetricsAccumulator(const MetricsParameters& parameters);

  /// Adds the time between two instants. Torque, reference, flux magnitude, current in the flux frame, speed
  /// and link power run linearly from `before` to `after`, and weigh by their duration; the window cuts a
  /// segment where its end lies. What jumps, as a reference does, jumps between the `after` of one segment
  /// and the `before` of the next. A segment without length has no weight.
  void add_segment(const MetricsSample& before, const MetricsSample& after) noexcept;

  /// Sets the switching state from an instant on; the same state changes nothing.
  void commutate(std::int64_t t_ns, SwitchState state) noexcept;

  /// Adds beginnings of a torque comparator's pulse at an instant.
  void pulse(std::int64_t t_ns, std::int64_t count = 1) noexcept;

  /// Temperatures of the machine up to an instant [°C]; NaN where they are not known.
  void note_temperatures(std::int64_t t_ns, const ThermalNodes<double>& temperatures) noexcept;

  /// Temperatures of the inverter's hottest junction and of its case up to an instant [°C].
  void note_inverter(std::int64_t t_ns, double junction, double device_case) noexcept;

  /// The run has control periods of this length. [ns]
  void has_control_period(std::int64_t period_ns);

  /// A control period begins with that telemetry and that commanded torque [N·m], after the segments of the
  /// one before it.
  void begin_period(const Telemetry<double>& telemetry, double command) noexcept {
    if (deviation_) deviation_->begin_period(telemetry, command);
  }

  /// The run has no torque comparator: there is no frequency of its pulses.
  void has_no_pulses() noexcept { has_pulses_ = false; }

  /// The metrics so far. Those of the simulation's speed, of the minimum dwell and of short
  /// pulses are the runner's to fill in.
  [[nodiscard]] MetricList metrics() const noexcept;

 private:
  enum Quantity : Eigen::Index { torque_error, flux, i_flux, i_quadrature, quantities };

  static constexpr std::int64_t settling_ns = 20'000'000;  // of the current, after a move of the reference

  struct WindowValues {
    Moments<quantities>::Values values{};  // current along the stator flux and 90 electrical degrees ahead
    double speed_error{};
    std::optional<LoadSample> load{};
  };

  // A segment, or what of it lies in the window.
  struct WindowPiece {
    WindowValues begin{}, end{};
    EnergyFlow flow{};
    double seconds{};
  };

  // Flux and current of one instant, the current in the frame of the flux: the end of a segment is mostly the
  // beginning of the next.
  struct FluxFrame {
    SpaceVector<> psi_s{}, i_s{};
    double flux{}, i_flux{}, i_quadrature{};
  };

  [[nodiscard]] const FluxFrame& flux_frame(const MetricsSample& sample) noexcept;
  [[nodiscard]] WindowValues window_values(const MetricsSample& sample) noexcept;
  void cut_to_window(WindowPiece& piece, const MetricsSample& before,
                     const MetricsSample& after) const noexcept;
  void note_current(SpaceVector<> i_s) noexcept;
  void note_reference(const MetricsSample& before, const MetricsSample& after) noexcept;
  void add_to_window(const WindowPiece& piece) noexcept;
  /// Least and largest of each value by itself.
  struct LoadRange {
    LoadSample least{};
    LoadSample largest{};
  };
  void note_load(const LoadSample& load) noexcept;
  struct InverterHeat {
    double junction{};     // [°C]
    double device_case{};  // [°C]
  };
  void fill_inverter_metrics(MetricList& m) const noexcept;
  void fill_window_metrics(MetricList& m) const noexcept;

  MetricsParameters parameters_;
  FluxFrame frame_{};
  StepResponse response_;
  std::optional<TorqueDeviation> deviation_{};  // of a sampled run
  Moments<quantities> moments_{};
  SteadyCurrent current_{};
  double speed_error_squares_{0};
  std::optional<LoadRange> load_{};  // in the window, behind a driveline
  EnergyAccount energy_{};           // of the window
  EnergyAccount balance_{};          // of the whole run
  std::int64_t turn_ons_{0};         // of the three upper switches
  std::int64_t pulses_{0};
  std::optional<SwitchState> switch_state_{};
  double peak_current_{0};
  std::optional<ThermalNodes<double>> hottest_{};   // in the window, where temperatures are known [°C]
  std::optional<InverterHeat> hottest_inverter_{};  // in the window, where it has losses
  double reference_{0};  // before the window and its settling; before the run zero [N·m]
  bool steady_{true};    // the reference stood still and every leg was driven, as far as the window goes
  bool has_pulses_{true};
  bool any_{false};
  bool finite_{true};
};

}  // namespace sextant
