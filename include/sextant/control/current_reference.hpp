#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// What a stator current is to make, and its largest magnitude.
template <class T = double>
struct CurrentDemand {
  T torque{};  ///< T_ref [N·m]
  T psi_s{};   ///< stator flux ψ_ref [Wb]
  T limit{};   ///< [A]
};

/// A limit of the stator current [A] that magnetises the machine to a stator flux [Wb]: nullptr, else what is
/// wrong with it.
template <class T>
[[nodiscard]] const char* validate_current_limit(T limit, const InductionMachineParameters<T>& machine,
                                                 T flux_reference) noexcept {
  const bool magnetises = std::isfinite(limit) && limit * machine.l_s() > flux_reference;
  return magnetises ? nullptr : "the current limit is below the current that magnetises the machine";
}

/// Stator current along and across the rotor flux of magnitude psi_r [Wb] that makes torque and stator flux
/// at once,
///   i_q = T_ref/(3/2 p k_r ψ_r),   i_d = (√(ψ_ref² − (σL_s i_q)²) − k_r ψ_r)/σL_s
/// In steady state, ψ_r = L_m i_d, that is L_s i_d = √(ψ_ref² − (σL_s i_q)²). Under this i_d the rotor flux
/// follows with σ τ_r instead of τ_r. Within the limit torque has priority over the rise of the flux, and the
/// flux that the torque needs has priority over torque. [A]
template <class T>
[[nodiscard]] SpaceVector<T> current_reference(const InductionMachineParameters<T>& machine, T psi_r,
                                               const CurrentDemand<T>& demand) noexcept {
  // √(whole² − part²), zero where the part exceeds the whole.
  const auto rest_of = [](T whole, T part) { return std::sqrt(std::max(T(0), whole * whole - part * part)); };
  const T main_flux = machine.k_r() * psi_r;
  const T per_ampere = T(1.5) * T(machine.pole_pairs) * main_flux;
  // Beside the current that holds the flux; else beside the one that brings it to its reference.
  const T holding = rest_of(demand.limit, psi_r / machine.l_m);
  const bool suffices = std::abs(demand.torque) <= per_ampere * holding;
  const T building = rest_of(demand.limit, (demand.psi_s - main_flux) / machine.sigma_l_s());
  const T wanted = per_ampere > T(0) ? demand.torque / per_ampere : T(0);
  const T i_q = suffices ? wanted : std::copysign(building, demand.torque);
  const T i_d = (rest_of(demand.psi_s, machine.sigma_l_s() * i_q) - main_flux) / machine.sigma_l_s();
  const T rest = rest_of(demand.limit, i_q);
  return {std::clamp(i_d, -rest, rest), i_q};
}

/// Stator flux of a current along and across a rotor flux of magnitude psi_r. [Wb]
template <class T>
[[nodiscard]] T stator_flux(const InductionMachineParameters<T>& machine, T psi_r,
                            SpaceVector<T> i_s) noexcept {
  return magnitude(SpaceVector<T>{machine.k_r() * psi_r, T(0)} + machine.sigma_l_s() * i_s);
}

}  // namespace sextant
