#pragma once

#include <limits>

#include "sextant/control/controller.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/drive/available_torque.hpp"
#include "sextant/drive/flux_slew.hpp"
#include "sextant/drive/held_flux.hpp"
#include "sextant/drive/motor_control.hpp"
#include "sextant/drive/optimal_flux.hpp"
#include "sextant/drive/present_limit.hpp"
#include "sextant/drive/torque_capability.hpp"
#include "sextant/drive/voltage_reserve.hpp"

namespace sextant {

/// The `MotorControl` of an induction machine: the controller, with its flux reference by torque, speed and
/// link voltage, and the torque that flux, voltage and current allow.
template <class T = double>
class InductionMotor {
 public:
  struct Parameters {
    typename TorqueCapability<T>::Parameters capability{};
    typename OptimalFlux<T>::Parameters optimal_flux{};

    [[nodiscard]] const char* validate(const ControlTiming& /*timing*/ = {}) const noexcept {
      if (const char* problem = capability.validate()) return problem;
      return optimal_flux.validate();
    }

    /// Whether this controller was built for the same periods and makes the voltage counted on.
    [[nodiscard]] const char* validate_with(const ControlTiming& timing,
                                            const Controller<T>& controller) const noexcept {
      if (capability.voltage_use > T(1) && !controller.reaches_six_step()) {
        return "the controller does not reach the share of voltage, which is above 1";
      }
      const ControlTiming built_for = controller.timing();
      if (built_for.period_ns == 0) return nullptr;
      if (built_for.period_ns != timing.period_ns) {
        return "the control periods of drive and controller differ";
      }
      return built_for.sampling_lead_ns == timing.sampling_lead_ns
                 ? nullptr
                 : "the sampling instants of drive and controller differ";
    }

    [[nodiscard]] T inertia() const noexcept { return capability.machine.inertia; }
  };

  /// The controller is not owned and must outlive the motor.
  InductionMotor(const Parameters& p, const ControlTiming& timing, Controller<T>& controller) noexcept
      : configured_flux_{p.capability.flux_reference},
        controller_{controller},
        capability_{p.capability},
        present_limit_{p.capability.machine, p.capability.flux_reference, p.capability.current_limit},
        reserve_{controller.holds_mean_torque(), p.capability.machine, p.capability.flux_reference,
                 timing.period_ns},
        optimal_flux_{p.optimal_flux, p.capability},
        flux_slew_{p.capability.machine},
        held_flux_{p.capability.machine, p.capability.current_limit} {}

  /// What machine and link allow in a steady state.
  [[nodiscard]] AvailableTorque<T> available(const Measurement<T>& measurement, T dt) noexcept {
    reserve_.step({.reference = reference_.torque,
                   .torque = estimate().torque - estimate().torque_ripple,
                   .omega_m = measurement.omega_m,
                   .u_dc = measurement.u_dc,
                   .flux_share = reference_.flux_share,
                   .makes_torque = reference_.mode == ControlMode::torque,
                   .interrupted = !measurement.applied.is_driven(),
                   .limited = limited_,
                   .slews = flux_slew_.is_slewing()},
                  dt);
    capability_.step(measurement.omega_m, measurement.u_dc, reserve_.usable());
    return capability_.available();
  }

  /// What flux and current allow now.
  [[nodiscard]] LimitedTorque<T> present_limit(T enough) const noexcept {
    return present_limit_.step(estimate().psi_s, i_s_, reference_.flux_share, enough);
  }

  /// The flux reference by the demand, and the controller's period.
  [[nodiscard]] GatePattern step(const Measurement<T>& measurement, const MotorDemand<T>& demand,
                                 T dt) noexcept SEXTANT_NONBLOCKING {
    const bool makes_torque = demand.mode == ControlMode::torque;
    const FluxDemand<T> flux{.torque = demand.steady_torque,
                             .omega_m = measurement.omega_m,
                             .needs_full_flux = demand.at_present_limit || !makes_torque,
                             .most = capability_.flux_share(demand.steady_torque)};
    const T target = optimal_flux_.step(flux, capability_, dt);
    const T held =
        makes_torque ? held_share(measurement, demand.steady_torque) : std::numeric_limits<T>::infinity();
    const T share =
        demand.mode != ControlMode::off ? flux_slew_.step(target, held, dt) : flux_slew_.reset(target);
    i_s_ = clarke(measurement.i_abc);
    limited_ = demand.limited;
    reference_ = {demand.mode, demand.torque, share};
    return controller_.step(measurement, reference_);
  }

  void discard_pattern() noexcept {
    reference_.mode = ControlMode::off;
    reference_.torque = T(0);
  }

  void restart() noexcept SEXTANT_NONBLOCKING { controller_.restart(); }

  [[nodiscard]] bool takes_parameters() const noexcept { return controller_.takes_parameters(); }
  void take_parameters(const InductionMotor& from) noexcept SEXTANT_NONBLOCKING {
    controller_.take_parameters(from.controller_);
    capability_.take_parameters(from.capability_);
    present_limit_ = from.present_limit_;
    reserve_.take_parameters(from.reserve_);
    optimal_flux_.take_parameters(from.optimal_flux_);
    held_flux_ = from.held_flux_;
  }

  [[nodiscard]] const ControlEstimate<T>& estimate() const noexcept { return controller_.estimate(); }
  [[nodiscard]] const ControlReference<T>& reference() const noexcept { return reference_; }
  [[nodiscard]] T flux_reference() const noexcept { return configured_flux_ * reference_.flux_share; }

 private:
  /// Share of the flux reference that the link can hold beside a torque [N·m]; infinite where it can hold the
  /// present one. [-]
  [[nodiscard]] T held_share(const Measurement<T>& measurement, T torque) const noexcept {
    const typename HeldFlux<T>::Now now{
        .psi_s = estimate().psi_s, .i_s = i_s_, .omega_m = measurement.omega_m, .u_dc = measurement.u_dc};
    return held_flux_.flux(now, torque, reference_.flux_share * configured_flux_) / configured_flux_;
  }

  T configured_flux_;  ///< [Wb]
  Controller<T>& controller_;
  TorqueCapability<T> capability_;
  PresentLimit<T> present_limit_;
  VoltageReserve<T> reserve_;
  OptimalFlux<T> optimal_flux_;
  FluxSlew<T> flux_slew_;
  HeldFlux<T> held_flux_;
  ControlReference<T> reference_{};  ///< of the controller's last step
  SpaceVector<T> i_s_{};             ///< stator current of the last step [A]
  bool limited_{false};              ///< less torque was made than requested, in the last period
};

}  // namespace sextant
