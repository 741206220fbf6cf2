#pragma once

#include <algorithm>

#include "sextant/control/bandwidth.hpp"
#include "sextant/control/modulated_controller.hpp"
#include "sextant/control/torque_dynamics.hpp"

namespace sextant {

/// Direct torque control with feedback linearisation and space-vector modulation. The voltage cancels what
/// makes torque and stator flux depend on each other and on the speed, and each follows its reference with
/// 1/(1 + s/α). With the unit vectors â along the rotor flux and ŝ along the stator flux, u_hold by
/// `torque_dynamics` and g = (1 − e^{−α t_period})/t_period,
///   â × u = u_hold + g σL_s (i_q* − i_q),   ŝ · u = R_s ŝ · i_s + g (ψ_s* − ψ_s)
///   u = ((ŝ · u) â + (â × u) jŝ)/(â · ŝ)
/// turned by what the flux turns by in half a period. i_q* and ψ_s* follow from `current_reference`. At 90°
/// between both fluxes, beyond the breakdown torque, no such voltage exists; â · ŝ is at least 0.3. Source:
/// C. Lascu, S. Jafarzadeh, M. S. Fadali, F. Blaabjerg, "Direct torque control with feedback linearization
/// for induction motor drives", IEEE Trans. Power Electron. 32 (2017) 2072–2080.
template <class T = double>
class FeedbackLinearisationController final : public ModulatedController<T> {
 public:
  static constexpr const char* name = "feedback_linearisation";
  static constexpr const char* meaning =
      "direct torque control with feedback linearisation and space-vector modulation";

  struct Parameters : BandwidthParameters<T> {};

  explicit FeedbackLinearisationController(const Parameters& parameters) noexcept
      : Base{parameters}, gain_{parameters.approach() / Base::period()} {}

  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING override {
    ModulatedController<T>::take_parameters(from);
    gain_ = static_cast<const FeedbackLinearisationController&>(from).gain_;
  }

 private:
  using Base = ModulatedController<T>;
  using typename Base::Demand;

  [[nodiscard]] SpaceVector<T> voltage(const Demand& d) noexcept SEXTANT_NONBLOCKING override {
    const InductionMachineParameters<T>& machine = Base::estimator().machine();
    const TorqueDynamics<T> now = torque_dynamics(Base::estimator(), d.x, Base::period());
    const SpaceVector<T> i_s = current_reference(machine, now.psi_r, Base::current_demand(d));
    const T psi_s = stator_flux(machine, now.psi_r, i_s);
    const SpaceVector<T> along_s = direction(d.x.psi_s);
    const T across = now.holding_voltage + gain_ * machine.sigma_l_s() * (i_s.beta - now.i_q);
    const T radial = machine.r_s * dot(along_s, d.x.i_s) + gain_ * (psi_s - dot(along_s, d.x.psi_s));
    const T cosine = std::max(dot(now.along, along_s), T(0.3));
    const SpaceVector<T> u = (T(1) / cosine) * (radial * now.along + across * rotate_90(along_s));
    return product(now.middle, u);
  }

  T gain_;  ///< g [1/s]
};

}  // namespace sextant
