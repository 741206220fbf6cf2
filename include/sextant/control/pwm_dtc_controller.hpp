#pragma once

#include "sextant/control/bandwidth.hpp"
#include "sextant/control/modulated_controller.hpp"
#include "sextant/control/torque_dynamics.hpp"

namespace sextant {

/// Direct torque control with PI controllers and space-vector modulation, at a constant switching frequency.
/// In the frame of the stator flux, which in steady state turns with the rotor flux's ω_s,
///   u_d = R_s i_d + PI(ψ_s* − ψ_s),   u_q = ω_s ψ_s + PI(T* − T)
/// with the gains α of the flux and α σL_s/(3/2 p ψ_ref) of the torque, and for both the integral time with
/// which the torque decays, σL_s/(R_s + k_r² R_r + σL_s/τ_r). ψ_s* and T* follow from `current_reference`:
/// while the flux is built up, they limit the torque to what the flux and the current limit make, so that
/// the current does not surge. Beyond the hexagon the integrals follow the realised voltage. Sources: C.
/// Lascu, I. Boldea, F. Blaabjerg, "A modified direct torque control for induction motor sensorless drive",
/// IEEE Trans. Ind. Appl. 36 (2000) 122–130; P. Brandstetter, M. Kuchar, H. H. Vo, C. S. Dong, "Induction
/// motor drive with PWM direct torque control", EPE 2017 (paper, [7]).
template <class T = double>
class PwmDtcController final : public ModulatedController<T> {
 public:
  static constexpr const char* name = "pwm_dtc";
  static constexpr const char* meaning =
      "direct torque control with PI controllers and space-vector modulation";

  struct Parameters : BandwidthParameters<T> {};

  explicit PwmDtcController(const Parameters& parameters) noexcept
      : Base{parameters}, gain_{parameters.approach() / Base::period()} {}

  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING override {
    ModulatedController<T>::take_parameters(from);
    gain_ = static_cast<const PwmDtcController&>(from).gain_;
  }

 private:
  using Base = ModulatedController<T>;
  using typename Base::Demand;

  [[nodiscard]] SpaceVector<T> voltage(const Demand& d) noexcept SEXTANT_NONBLOCKING override {
    const InductionMachineParameters<T>& machine = Base::estimator().machine();
    const TorqueDynamics<T> now = torque_dynamics(Base::estimator(), d.x, Base::period());
    const SpaceVector<T> i_s = current_reference(machine, now.psi_r, Base::current_demand(d));
    const SpaceVector<T> along = direction(d.x.psi_s);
    const T psi_s = dot(along, d.x.psi_s);
    const T omega_s = (T(2) / Base::period()) * now.middle.beta;
    const SpaceVector<T> known{machine.r_s * dot(along, d.x.i_s), omega_s * psi_s};
    // (T* − T)/(3/2 p ψ_ref) in the place of a current.
    const T current_error = machine.k_r() * now.psi_r / d.psi_ref * (i_s.beta - now.i_q);
    const SpaceVector<T> proportional{gain_ * (stator_flux(machine, now.psi_r, i_s) - psi_s),
                                      gain_ * machine.sigma_l_s() * current_error};
    const SpaceVector<T> frame = product(now.middle, along);
    const SpaceVector<T> u = product(frame, known + proportional + integral_);
    const SpaceVector<T> lacking = Base::realised(u, d.u_dc) - u;
    integral_ += (Base::period() * now.decay_rate) *
                 (proportional + SpaceVector<T>{dot(frame, lacking), cross(frame, lacking)});
    return u;
  }

  void release() noexcept SEXTANT_NONBLOCKING override { integral_ = {}; }

  T gain_;                     ///< (1 − e^{−α t_period})/t_period [1/s]
  SpaceVector<T> integral_{};  ///< in the frame of the stator flux [V]
};

}  // namespace sextant
