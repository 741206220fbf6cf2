#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/control/modulated_controller.hpp"

namespace sextant {

/// Deadbeat direct torque and flux control with space-vector modulation: the voltage with which torque and
/// stator flux meet their references at the end of the coming period. In the frame of the rotor flux at that
/// end,
///   i_q = T_ref/(3/2 p k_r ψ_r),   i_d = (√(ψ_ref² − (σL_s i_q)²) − k_r ψ_r)/σL_s
///   ψ_s* = k_r ψ_r + σL_s (i_d + j i_q),   u = (ψ_s* − ψ_s)/t_period + R_s (i_s + i_s*)/2
/// Both currents stay within the current limit: torque has priority over the rise of the flux, and the flux
/// that the torque needs has priority over torque. Source: B. H. Kenny, R. D. Lorenz, "Stator- and rotor-flux-
/// based deadbeat direct torque control of induction machines", IEEE Trans. Ind. Appl. 39 (2003) 1093–1101.
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
    const T length = magnitude(psi_r);
    const SpaceVector<T> along = direction(psi_r);
    const SpaceVector<T> wanted = current(demand, machine, length);
    const SpaceVector<T> i_s = product(wanted, along);
    const SpaceVector<T> psi_s = machine.k_r() * psi_r + machine.sigma_l_s() * i_s;
    return (T(1) / Base::period()) * (psi_s - x.psi_s) + (T(0.5) * machine.r_s) * (x.i_s + i_s);
  }

  /// Current along and across the rotor flux ψ_r [Wb]. [A]
  [[nodiscard]] SpaceVector<T> current(const Demand& demand, const InductionMachineParameters<T>& machine,
                                       T psi_r) const noexcept {
    const T limit = Base::current_limit();
    const T main_flux = machine.k_r() * psi_r;
    const T per_ampere = T(1.5) * T(machine.pole_pairs) * main_flux;
    // Beside the current that holds the flux; else beside the one that brings it to its reference.
    const T holding = rest_of(limit, psi_r / machine.l_m);
    const bool suffices = std::abs(demand.torque) <= per_ampere * holding;
    const T building = rest_of(limit, (demand.psi_ref - main_flux) / machine.sigma_l_s());
    const T wanted = per_ampere > T(0) ? demand.torque / per_ampere : T(0);
    const T i_q = suffices ? wanted : std::copysign(building, demand.torque);
    const T i_d = (rest_of(demand.psi_ref, machine.sigma_l_s() * i_q) - main_flux) / machine.sigma_l_s();
    const T rest = rest_of(limit, i_q);
    return {std::clamp(i_d, -rest, rest), i_q};
  }

  /// √(whole² − part²), zero where the part exceeds the whole.
  [[nodiscard]] static T rest_of(T whole, T part) noexcept {
    return std::sqrt(std::max(T(0), whole * whole - part * part));
  }
};

}  // namespace sextant
