#pragma once

#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// ΔT = 3/2 p ψ_ref (2/3 u_dc)/σL_s · t_period: what an active vector across the flux changes of the torque
/// in a control period, but for what the EMF and the resistances change. [N·m]
/// psi_ref [Wb], u_dc [V], period [s].
template <class T>
[[nodiscard]] constexpr T vector_torque(const InductionMachineParameters<T>& machine, T psi_ref, T u_dc,
                                        T period) noexcept {
  return T(machine.pole_pairs) * psi_ref * u_dc * period / machine.sigma_l_s();
}

/// Narrowest band of each relay of the torque comparator within which a switching table can hold the torque,
/// ΔT/4. The table's active vectors are at 30° to 150° to the flux, so that they change the torque by ΔT/2 to
/// ΔT in a period. The relays hold between T_ref − HB and T_ref + HB. Where 2 HB is below ΔT/2, every vector
/// that raises the torque from one threshold passes the other one, and the opposite vector follows where a
/// zero vector would do. That one takes with it what the EMF changes, and a bias of the mean torque remains.
/// [N·m]
template <class T>
[[nodiscard]] constexpr T narrowest_torque_band(T vector_torque) noexcept {
  return T(0.25) * vector_torque;
}

}  // namespace sextant
