#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/control/admissible_pulse.hpp"
#include "sextant/control/control_basis.hpp"
#include "sextant/control/controller.hpp"
#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/control/magnetising_control.hpp"
#include "sextant/control/nearest_state.hpp"
#include "sextant/control/space_vector_modulator.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/core/iron_torque.hpp"
#include "sextant/core/sampling_instant.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/winding_resistance.hpp"

namespace sextant {

/// What the control methods share: estimate of flux and torque, compensation of the actuation delay,
/// magnetising. A method adds the pattern that follows the torque reference.
///
/// Magnetising is to make no torque, and its voltage is modulated with every method. By the nearest of few
/// vectors the current misses its reference by up to half of what a vector changes, and where the EMF is
/// small the error across the flux, and with it a torque, lasts: it changes by |ω_r| ψ t_period/σL_s a period
/// only, and a vector corrects it once it has passed that half.
///
/// Over-modulation that holds the fundamental adds harmonics to the voltage, and these to flux and current.
/// By superposition, as the machine is linear at a given speed, they follow from `predict` with the harmonics
/// of the voltage. The methods get flux and current without them and do not counteract what the inverter
/// cannot avoid.
template <class T = double>
class EstimatingController : public Controller<T> {
 public:
  struct Parameters {
    InductionMachineParameters<T> machine{};           ///< the controller's parameters of the machine
    SaturationParameters<T> saturation{};              ///< of the machine's main flux; none by default
    typename InverterModel<T>::Parameters inverter{};  ///< what makes the voltage of the patterns
    std::int32_t period_ns{25'000};                    ///< control period [ns]
    T flux_reference{T(1.1)};                          ///< ψ_ref at a flux share of 1 [Wb]
    FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
    bool adapts_parameters{true};  ///< R_s, R_r and L_m follow the machine, with the kinds that identify them
    WindingResistance<T> winding{};  ///< by which R_s in use follows the measurement's winding temperature
    T iron_loss_resistance{no_iron_loss<T>};  ///< R_fe per phase; infinite: none [Ω]
    std::int32_t sampling_lead_ns{0};         ///< from the sample of the currents to the control period [ns]
    int actuation_delay_periods{0};           ///< 1 when a pattern is applied one period late [-]
    typename Magnetiser<T>::Parameters magnetiser{};

    /// Takes what the controller has in common with the drive.
    void set_basis(const ControlBasis<T>& basis) noexcept {
      machine = basis.machine;
      saturation = basis.saturation;
      inverter = basis.inverter;
      period_ns = basis.period_ns;
      flux_reference = basis.flux_reference;
      flux_estimator = basis.flux_estimator;
      adapts_parameters = basis.adapts_parameters;
      winding = basis.winding;
      iron_loss_resistance = basis.iron_loss_resistance;
      sampling_lead_ns = basis.sampling_lead_ns;
      actuation_delay_periods = basis.actuation_delay_periods;
    }
    /// Sets what follows from it.
    void set_defaults(const ControlBasis<T>& basis) noexcept {
      magnetiser = Magnetiser<T>::Parameters::by_default(basis);
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (!(std::isfinite(flux_reference) && flux_reference > T(0))) {
        return "the flux reference must be above zero";
      }
      if (sampling_lead_ns < 0 || sampling_lead_ns > period_ns) {
        return "the sampling lead must be from zero to the control period";
      }
      if (actuation_delay_periods < 0 || actuation_delay_periods > 1) {
        return "the actuation delay must be 0 or 1 periods";
      }
      if (const char* problem = inverter.validate(period_ns)) return problem;
      if (const char* problem = machine.validate()) return problem;
      if (const char* problem = saturation.validate()) return problem;
      if (const char* problem = winding.validate()) return problem;
      if (!(iron_loss_resistance > T(0))) return "the resistance of the iron loss must be above zero";
      return magnetiser.validate(machine, flux_reference);
    }
  };

  [[nodiscard]] GatePattern step(const Measurement<T>& measurement,
                                 ControlReference<T> reference) noexcept SEXTANT_NONBLOCKING final {
    estimator_.step(sampling_.step(measurement), mode_ == ControlMode::magnetise);
    mode_ = reference.mode;
    estimate_.psi_s = estimator_.psi_s();
    estimate_.psi_s_magnitude = magnitude(estimate_.psi_s);
    estimate_.torque = estimator_.torque();
    estimate_.r_s = estimator_.machine().r_s;
    estimate_.r_r = estimator_.machine().r_r;
    estimate_.l_m = estimator_.machine().l_m;
    estimate_.r_s_deviation = estimator_.deviations().r_s;
    estimate_.r_r_deviation = estimator_.deviations().r_r;
    estimate_.l_m_deviation = estimator_.deviations().l_m;
    const GatePattern pattern = mode_ == ControlMode::off ? turn_off() : decide(measurement, reference);
    if (!estimator_.inverter().is_ideal()) in_flight_ = pattern;
    estimate_.magnetised = magnetising_.done();
    estimate_.torque -= estimator_.iron_loss_torque();
    return pattern;
  }

  [[nodiscard]] ControlTiming timing() const noexcept final {
    return {parameters_.period_ns, parameters_.sampling_lead_ns};
  }

  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING override {
    estimator_.take_iron_loss(static_cast<const EstimatingController&>(from).estimator_);
  }

  void reset() noexcept SEXTANT_NONBLOCKING final {
    estimator_.reset();
    stop();
  }

  void restart() noexcept SEXTANT_NONBLOCKING final {
    estimator_.restart();
    stop();
  }

 protected:
  using Controller<T>::estimate_;

  /// A period in which the torque is to follow its reference.
  struct Demand {
    FluxAndCurrent<T> x;  ///< when the pattern begins, without the harmonics of over-modulation
    T torque{};           ///< T_ref and what the iron loss takes of it: of ψ_s × i_s [N·m]
    T psi_ref{};          ///< [Wb]
    T u_dc{};             ///< [V]
  };

  using Modulator = SpaceVectorModulator<T>;

  /// modulator: of the voltages that are modulated.
  explicit EstimatingController(const Parameters& parameters,
                                const typename Modulator::Parameters& modulator = {}) noexcept
      : parameters_{parameters},
        period_{T(parameters.period_ns) * T(1e-9)},
        sampling_{parameters.sampling_lead_ns},
        estimator_{{parameters.machine, parameters.flux_estimator, parameters.adapts_parameters,
                    parameters.inverter, parameters.flux_reference, parameters.saturation, parameters.winding,
                    parameters.iron_loss_resistance}},
        magnetising_{parameters.magnetiser, period_},
        modulator_{modulator_of(modulator, parameters)},
        admissible_{AdmissiblePulse::symmetric(parameters.inverter.minimum_pulse.duration_ns)} {}

  /// The pattern with which the torque follows its reference. It must call `drive`.
  [[nodiscard]] virtual GatePattern follow(const Demand& demand) noexcept SEXTANT_NONBLOCKING = 0;
  /// The torque follows no reference; `estimate_` is that of this period.
  virtual void release() noexcept SEXTANT_NONBLOCKING {}
  /// The method's own state is as after power-up.
  virtual void reset_method() noexcept SEXTANT_NONBLOCKING {}

  /// The mean stator voltage of the pattern that is decided, with every leg driven. [V]
  void drive(SpaceVector<T> u) noexcept {
    u_in_flight_ = u;
    is_driven_ = true;
  }
  /// One switching state for the whole period.
  [[nodiscard]] GatePattern whole_period(SwitchState state, T u_dc) noexcept {
    drive(stator_voltage(state, u_dc));
    present_ = state;
    return GatePattern{state, parameters_.period_ns};
  }
  /// An active state for a share of the period, in [0, 1], or for the nearest one that the inverter's minimum
  /// pulse admits, between two halves of its nearest zero vector; v: its voltage. [V]
  [[nodiscard]] GatePattern pulse(SwitchState active, T share, SpaceVector<T> v) noexcept {
    const auto active_ns =
        admissible_.nearest(std::int32_t(share * T(parameters_.period_ns)), parameters_.period_ns);
    const SwitchState zero = nearest_zero_state(active);
    const std::int32_t rest_ns = parameters_.period_ns - active_ns;
    GatePattern pattern;
    pattern.append({zero, rest_ns / 2});
    pattern.append({active, active_ns});
    pattern.append({zero, rest_ns - rest_ns / 2});
    drive((T(active_ns) / T(parameters_.period_ns)) * v);
    present_ = pattern.last_state();
    return pattern;
  }
  /// The state whose share of the period is nearest to u [V], of the multiples of `quantum`, or a zero
  /// vector.
  [[nodiscard]] GatePattern nearest(SpaceVector<T> u, T u_dc, T quantum) noexcept {
    const NearestVector<T> found = nearest_vector(u, u_dc, present_, quantum);
    if (found.share >= T(1)) return whole_period(found.state, u_dc);
    return pulse(found.state, found.share, stator_voltage(found.state, u_dc));
  }
  /// The pattern whose mean voltage is u, or the nearest one within the hexagon. [V]
  [[nodiscard]] GatePattern modulate(SpaceVector<T> u, T u_dc) noexcept {
    const SpaceVector<T> within = modulator_.mean_voltage(u, u_dc);
    drive(within);
    const GatePattern pattern =
        modulator_.step(within, u_dc, parameters_.period_ns, leg_correction(within, u_dc));
    if (modulator_.holds_fundamental()) {
      harmonics_ = predict(estimator_, harmonics_, within - modulator_.fundamental(u, u_dc), period_);
    }
    present_ = pattern.last_state();
    return pattern;
  }
  /// What `modulate` makes of such a voltage, without the harmonics of over-modulation. [V]
  [[nodiscard]] SpaceVector<T> realised(SpaceVector<T> u, T u_dc) const noexcept {
    return modulator_.fundamental(u, u_dc);
  }
  /// The voltage that `modulate` makes has the one demanded as its fundamental, up to six-step.
  [[nodiscard]] constexpr bool holds_fundamental() const noexcept { return modulator_.holds_fundamental(); }
  /// That of `MagnetisingControl`, for the flux reference [Wb] and the link voltage [V]. [-]
  [[nodiscard]] T vector_quantum(T psi_ref, T u_dc) const noexcept {
    return magnetising_.vector_quantum(parameters_.machine, psi_ref, u_dc);
  }
  /// The last pattern is a zero vector for the whole period.
  [[nodiscard]] bool rests() const noexcept {
    return is_driven_ && u_in_flight_.alpha == T(0) && u_in_flight_.beta == T(0);
  }
  /// The state in force at the end of the last pattern of these, until the gates go off.
  [[nodiscard]] SwitchState present() const noexcept { return present_; }

  /// By how much longer each leg is to be high for the inverter to make the mean voltage u [V] of the pattern
  /// for an ideal one: what that would lack, by the link voltage. Zero for an ideal inverter. [s]
  [[nodiscard]] ThreePhase<T> leg_correction(SpaceVector<T> u, T u_dc) const noexcept {
    const InverterModel<T>& inverter = estimator_.inverter();
    if (inverter.is_ideal() || !(u_dc > T(0))) return {};
    typename InverterModel<T>::Legs legs = legs_;
    const SpaceVector<T> i_end = predict(estimator_, x_, u, period_).i_s;
    const GatePattern ideal = Modulator{modulator_}.step(u, u_dc, parameters_.period_ns);
    const ThreePhase<T> beyond = inverter.predicted(ideal, x_.i_s, i_end, u_dc, legs);
    const T per_volt = T(-1) / u_dc;
    return {per_volt * beyond.a, per_volt * beyond.b, per_volt * beyond.c};
  }

  [[nodiscard]] const FluxTorqueEstimator<T>& estimator() const noexcept { return estimator_; }
  [[nodiscard]] T period() const noexcept { return period_; }  ///< [s]
  [[nodiscard]] std::int32_t period_ns() const noexcept { return parameters_.period_ns; }

 private:
  [[nodiscard]] static constexpr typename Modulator::Parameters modulator_of(
      typename Modulator::Parameters modulator, const Parameters& parameters) noexcept {
    modulator.minimum_pulse_ns = parameters.inverter.minimum_pulse.duration_ns;
    return modulator;
  }

  [[nodiscard]] GatePattern decide(const Measurement<T>& m, const ControlReference<T>& reference) noexcept {
    const T psi_ref = reference.flux_share * parameters_.flux_reference;
    x_ = ahead(m.u_dc);
    const FluxAndCurrent<T> x{x_.psi_s - harmonics_.psi_s, x_.i_s - harmonics_.i_s};
    if (modulator_.holds_fundamental()) {
      estimate_.torque_ripple =
          T(1.5) * T(parameters_.machine.pole_pairs) * (cross(x_.psi_s, x_.i_s) - cross(x.psi_s, x.i_s));
    }
    if (mode_ == ControlMode::torque)
      return follow({x, reference.torque + estimator_.iron_loss_torque(), psi_ref, m.u_dc});
    release();
    const T u_most = modulator_.longest(m.u_dc);
    return modulate(magnetising_.step(estimator_, x, estimate_.psi_s_magnitude, psi_ref, u_most, m.omega_m),
                    m.u_dc);
  }

  void stop() noexcept {
    sampling_.reset();
    modulator_.reset();
    estimate_ = {};
    in_flight_ = {};
    (void)turn_off();
    reset_method();
    mode_ = ControlMode::off;
  }

  /// Flux, current and legs when the pattern that is decided now begins.
  [[nodiscard]] FluxAndCurrent<T> ahead(T u_dc) noexcept {
    FluxAndCurrent<T> x{estimator_.psi_s(), estimator_.i_s()};
    legs_ = estimator_.inverter().legs();
    if (const GatePattern& since = sampling_.since(); since.is_driven()) {
      const T lead = T(since.duration_ns()) * T(1e-9);
      x = after(x, since, (T(1) / lead) * volt_seconds(since, u_dc), u_dc, lead);
    }
    if (parameters_.actuation_delay_periods == 0) return x;
    if (is_driven_) return after(x, in_flight_, u_in_flight_, u_dc, period_);
    estimator_.inverter().pass(in_flight_, legs_);
    return x;
  }

  /// Flux and current dt [s] after those of x, under a pattern of the mean voltage u [V] by an ideal
  /// inverter. The legs are left as they are then.
  [[nodiscard]] FluxAndCurrent<T> after(const FluxAndCurrent<T>& x, const GatePattern& pattern,
                                        SpaceVector<T> u, T u_dc, T dt) noexcept {
    const InverterModel<T>& inverter = estimator_.inverter();
    if (inverter.is_ideal()) return predict(estimator_, x, u, dt);
    // A pattern with corrected edges has another mean.
    const SpaceVector<T> commanded = volt_seconds(pattern, u_dc);
    const SpaceVector<T> i_end = predict(estimator_, x, (T(1) / dt) * commanded, dt).i_s;
    const SpaceVector<T> beyond = clarke(inverter.predicted(pattern, x.i_s, i_end, u_dc, legs_));
    return predict(estimator_, x, (T(1) / dt) * (commanded + beyond), dt);
  }

  /// A period with the gates off.
  [[nodiscard]] GatePattern turn_off() noexcept {
    magnetising_.reset();
    release();
    harmonics_ = {};
    estimate_.torque_ripple = T(0);
    is_driven_ = false;
    present_ = gates_off;
    return GatePattern{gates_off, parameters_.period_ns};
  }

  Parameters parameters_;
  T period_;  ///< [s]
  SamplingInstant<T> sampling_;
  FluxTorqueEstimator<T> estimator_;
  MagnetisingControl<T> magnetising_;
  Modulator modulator_;
  AdmissiblePulse admissible_;              ///< of one active vector
  FluxAndCurrent<T> x_{};                   ///< when the pattern begins that is decided now
  FluxAndCurrent<T> harmonics_{};           ///< part of x_ that over-modulation makes
  SpaceVector<T> u_in_flight_{};            ///< mean voltage of the last pattern by an ideal inverter [V]
  bool is_driven_{false};                   ///< the last pattern drives every leg
  typename InverterModel<T>::Legs legs_{};  ///< when the pattern begins that is decided now
  GatePattern in_flight_{};                 ///< the last pattern; empty with an ideal inverter
  SwitchState present_{gates_off};
  ControlMode mode_{ControlMode::off};
};

}  // namespace sextant
