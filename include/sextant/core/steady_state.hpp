#pragma once

#include <cmath>
#include <limits>
#include <numbers>

#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// An induction machine in steady state at constant stator flux linkage, in the frame in which the flux is
/// real (ψ_s = ψ): the T-equivalent circuit with ψ in place of the stator voltage.
template <class T = double>
struct SteadyState {
  T torque{};      ///< electromagnetic [N·m]
  T i_d{};         ///< along the flux [A]
  T i_q{};         ///< across it [A]
  T omega_slip{};  ///< electrical, stator frequency above that of the rotor [rad/s]

  /// Magnitude of the stator current. [A]
  [[nodiscard]] T current() const noexcept { return std::hypot(i_d, i_q); }
};

/// The steady state at relative slip x = ω_slip σ τ_r, from −1 to 1 (the breakdown torques):
///   i_s = ψ/L_s · (1 + j x/σ) / (1 + j x),   τ_e = 3/2 p ψ i_q
/// psi is the stator flux linkage [Wb].
template <class T>
[[nodiscard]] SteadyState<T> steady_state(const InductionMachineParameters<T>& m, T psi, T x) noexcept {
  const T sigma = m.sigma_l_s() / m.l_s();
  const T scale = psi / (m.l_s() * (T(1) + x * x));
  const T i_q = scale * (x / sigma - x);
  return {.torque = T(1.5) * T(m.pole_pairs) * psi * i_q,
          .i_d = scale * (T(1) + x * x / sigma),
          .i_q = i_q,
          .omega_slip = x / (sigma * m.tau_r())};
}

/// Largest torque at a stator flux linkage [Wb]: T_b = 3/4 p L_m²/(σ L_s² L_r) ψ². [N·m]
template <class T>
[[nodiscard]] T breakdown_torque(const InductionMachineParameters<T>& m, T psi) noexcept {
  return steady_state(m, psi, T(1)).torque;
}

/// Relative slip on the stable branch at a torque: τ_e/T_b = 2x/(1 + x²); 1 at and beyond the breakdown. [-]
template <class T>
[[nodiscard]] T relative_slip(T torque, T breakdown) noexcept {
  const T share = torque / breakdown;
  if (!(share < T(1))) return T(1);
  return share / (T(1) + std::sqrt(T(1) - share * share));
}

/// Largest amplitude of the stator voltage available in every direction from a two-level inverter: u_dc/√3.
/// [V]
template <class T>
[[nodiscard]] constexpr T linear_voltage(T u_dc) noexcept {
  return u_dc * T(1 / std::numbers::sqrt3);
}

/// Fundamental of six-step, 2/π u_dc, by `linear_voltage`. [-]
template <class T>
inline constexpr T six_step_share = T(2 * std::numbers::sqrt3 / std::numbers::pi);

/// The stator flux with which a machine without resistance meets that voltage at a frequency [Hz]: that of
/// its data sheet gives the rated flux, where link and machine are made for each other. [Wb]
template <class T>
[[nodiscard]] constexpr T flux_at_voltage_limit(T u_dc, T frequency) noexcept {
  return linear_voltage(u_dc) / (T(2 * std::numbers::pi) * frequency);
}

/// The mechanical speed at which a machine with flux psi [Wb] and no torque meets the voltage limit:
///   (R_s ψ/L_s)² + (p ω_m ψ)² = (u_dc/√3)²
/// 0 where the link voltage does not suffice for the flux at standstill. [rad/s]
template <class T>
[[nodiscard]] T zero_torque_speed(const InductionMachineParameters<T>& m, T psi, T u_dc) noexcept {
  const T u = linear_voltage(u_dc);
  const T u_d = m.r_s * psi / m.l_s();
  if (!(u > u_d)) return T(0);
  return std::sqrt(u * u - u_d * u_d) / (T(m.pole_pairs) * psi);
}

}  // namespace sextant
