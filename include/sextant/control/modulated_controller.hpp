#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/control/controller.hpp"
#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/control/magnetising_control.hpp"
#include "sextant/control/space_vector_modulator.hpp"

namespace sextant {

/// What the controllers share that demand a voltage and leave the switching to a `SpaceVectorModulator`:
/// estimator, compensation of the actuation delay, magnetising, modulation. A method adds how the voltage
/// follows from flux, current and references.
template <class T = double>
class ModulatedController : public Controller<T> {
 public:
  struct Parameters {
    InductionMachineParameters<T> machine{};  ///< the controller's parameters of the machine
    std::int32_t period_ns{25'000};           ///< control period [ns]
    T flux_reference{T(1.1)};                 ///< ψ_ref at a flux share of 1 [Wb]
    FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
    int actuation_delay_periods{0};  ///< 1 when a pattern is applied one period late [-]
    T current_limit{T(250)};         ///< of the stator current that torque and flux may take [A]
    typename Magnetiser<T>::Parameters magnetiser{};
    typename SpaceVectorModulator<T>::Parameters modulator{};

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (!(std::isfinite(flux_reference) && flux_reference > T(0))) {
        return "the flux reference must be above zero";
      }
      if (actuation_delay_periods < 0 || actuation_delay_periods > 1) {
        return "the actuation delay must be 0 or 1 periods";
      }
      if (const char* problem = machine.validate()) return problem;
      if (const char* problem = modulator.validate()) return problem;
      if (!(std::isfinite(current_limit) && current_limit * machine.l_s() > flux_reference)) {
        return "the current limit is below the current that magnetises the machine";
      }
      if (const char* problem = magnetiser.validate(machine, flux_reference)) return problem;
      return nullptr;
    }
  };

  explicit ModulatedController(const Parameters& parameters) noexcept
      : parameters_{parameters},
        period_{T(parameters.period_ns) * T(1e-9)},
        estimator_{parameters.machine, parameters.flux_estimator},
        magnetising_{parameters.magnetiser, period_},
        modulator_{parameters.modulator} {}

  [[nodiscard]] GatePattern step(const Measurement<T>& measurement,
                                 ControlReference<T> reference) noexcept SEXTANT_NONBLOCKING final {
    estimator_.step(measurement, mode_ == ControlMode::magnetise);
    mode_ = reference.mode;
    estimate_.psi_s = estimator_.psi_s();
    estimate_.psi_s_magnitude = magnitude(estimate_.psi_s);
    estimate_.torque = estimator_.torque();
    const GatePattern pattern = next_pattern(measurement, reference);
    estimate_.magnetised = magnetising_.done();
    return pattern;
  }

  void reset() noexcept SEXTANT_NONBLOCKING final {
    estimator_.reset();
    estimate_ = {};
    rest();
    modulator_.reset();
    mode_ = ControlMode::off;
  }

 protected:
  /// A period in which the torque is to follow its reference.
  struct Demand {
    FluxAndCurrent<T> x;  ///< when the pattern begins
    T torque{};           ///< T_ref [N·m]
    T psi_ref{};          ///< [Wb]
    T u_dc{};             ///< [V]
  };

  /// The stator voltage of that period, which the modulator limits to the hexagon. [V]
  [[nodiscard]] virtual SpaceVector<T> voltage(const Demand& demand) noexcept SEXTANT_NONBLOCKING = 0;
  /// What the modulator makes of such a voltage. [V]
  [[nodiscard]] SpaceVector<T> realised(SpaceVector<T> u, T u_dc) const noexcept {
    return modulator_.within_hexagon(u, u_dc);
  }
  /// The torque follows no reference.
  virtual void release() noexcept SEXTANT_NONBLOCKING {}

  [[nodiscard]] const FluxTorqueEstimator<T>& estimator() const noexcept { return estimator_; }
  [[nodiscard]] T period() const noexcept { return period_; }  ///< [s]
  [[nodiscard]] T current_limit() const noexcept { return parameters_.current_limit; }

 private:
  using Controller<T>::estimate_;

  [[nodiscard]] GatePattern next_pattern(const Measurement<T>& m,
                                         const ControlReference<T>& reference) noexcept {
    const T psi_ref = reference.flux_share * parameters_.flux_reference;
    switch (reference.mode) {
      case ControlMode::torque:
        return modulated(voltage({ahead(), reference.torque, psi_ref, m.u_dc}), m.u_dc);
      case ControlMode::magnetise:
        release();
        return modulated(magnetising_.step(estimator_, ahead(), estimate_.psi_s_magnitude, psi_ref, m.u_dc,
                                           m.omega_m, T(0)),
                         m.u_dc);
      case ControlMode::off:
        break;
    }
    rest();
    return GatePattern{gates_off, parameters_.period_ns};
  }

  /// Flux and current when the pattern that is decided now begins.
  [[nodiscard]] FluxAndCurrent<T> ahead() const noexcept {
    if (parameters_.actuation_delay_periods == 0 || !is_driven_) {
      return {estimator_.psi_s(), estimator_.i_s()};
    }
    return predict(estimator_, u_in_flight_, period_);
  }

  [[nodiscard]] GatePattern modulated(SpaceVector<T> u, T u_dc) noexcept {
    u_in_flight_ = modulator_.within_hexagon(u, u_dc);
    is_driven_ = true;
    return modulator_.step(u_in_flight_, u_dc, parameters_.period_ns);
  }

  void rest() noexcept {
    magnetising_.reset();
    release();
    is_driven_ = false;
  }

  Parameters parameters_;
  T period_;  ///< [s]
  FluxTorqueEstimator<T> estimator_;
  MagnetisingControl<T> magnetising_;
  SpaceVectorModulator<T> modulator_;
  SpaceVector<T> u_in_flight_{};  ///< mean voltage of the last pattern [V]
  bool is_driven_{false};         ///< the last pattern drives every leg
  ControlMode mode_{ControlMode::off};
};

}  // namespace sextant
