#pragma once

#include "sextant/control/current_reference.hpp"
#include "sextant/control/modulated_controller.hpp"

namespace sextant {

/// Deadbeat direct torque and flux control with space-vector modulation: the voltage with which torque and
/// stator flux meet their references at the end of the coming period. In the frame of the rotor flux at that
/// end, with i_s* = i_d + j i_q by `current_reference`, which keeps the current within its limit,
///   ψ_s* = k_r ψ_r + σL_s i_s*,   u = (ψ_s* − ψ_s)/t_period + R_s (i_s + i_s*)/2
/// Source: B. H. Kenny, R. D. Lorenz, "Stator- and rotor-flux-based deadbeat direct torque control of
/// induction machines", IEEE Trans. Ind. Appl. 39 (2003) 1093–1101.
template <class T = double>
class DeadbeatController final : public ModulatedController<T> {
 public:
  static constexpr const char* name = "deadbeat";
  static constexpr const char* meaning = "deadbeat direct torque control with space-vector modulation";

  struct Parameters : ModulatedController<T>::Parameters {};

  explicit DeadbeatController(const Parameters& parameters) noexcept : ModulatedController<T>{parameters} {}

 private:
  using Base = ModulatedController<T>;
  using typename Base::Demand;

  [[nodiscard]] SpaceVector<T> voltage(const Demand& demand) noexcept SEXTANT_NONBLOCKING override {
    const FluxTorqueEstimator<T>& estimator = Base::estimator();
    const InductionMachineParameters<T>& machine = estimator.machine();
    const CurrentModel<T>& model = estimator.current_model();
    const FluxAndCurrent<T>& x = demand.x;
    const SpaceVector<T> now = model.psi_r_from(x.psi_s, x.i_s);
    const SpaceVector<T> psi_r = now + Base::period() * model.derivative(now, x.i_s, estimator.omega_m());
    const SpaceVector<T> wanted = current_reference(
        machine, magnitude(psi_r), CurrentDemand<T>{demand.torque, demand.psi_ref, Base::current_limit()});
    const SpaceVector<T> i_s = product(wanted, direction(psi_r));
    const SpaceVector<T> psi_s = machine.k_r() * psi_r + machine.sigma_l_s() * i_s;
    return (T(1) / Base::period()) * (psi_s - x.psi_s) + (T(0.5) * machine.r_s) * (x.i_s + i_s);
  }
};

}  // namespace sextant
