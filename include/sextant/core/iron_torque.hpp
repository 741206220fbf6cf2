#pragma once

#include <limits>

namespace sextant {

/// R_fe of a machine without iron loss. [Ω]
template <class T>
inline constexpr T no_iron_loss = std::numeric_limits<T>::infinity();

/// What the iron loss of a machine takes from the torque of its stator flux and current, 3/2 p ψ_s × i_s,
/// before the shaft: with P_fe = 3/2 (ω_e ψ_s)²/R_fe, the loss of a resistance per phase across the voltage
/// that the stator flux induces,
///   τ_fe = p P_fe/ω_e = 3/2 p ω_e ψ_s²/R_fe
/// against the rotation of the flux. Source: E. Levi, "Impact of iron loss on behavior of vector controlled
/// induction machines", IEEE Trans. Ind. Appl. 31 (1995) 1287–1296. [N·m]
/// torque_gain: 3/2 p [-]; conductance: 1/R_fe [1/Ω]; omega_e: of the flux, electrical [rad/s]; flux_squared:
/// ψ_s² [Wb²].
template <class T>
[[nodiscard]] constexpr T iron_torque(T torque_gain, T conductance, T omega_e, T flux_squared) noexcept {
  return torque_gain * conductance * omega_e * flux_squared;
}

}  // namespace sextant
