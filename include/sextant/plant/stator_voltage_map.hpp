#pragma once

#include <array>
#include <cstddef>

#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/leg_tie.hpp"

namespace sextant {

/// Stator voltage under given ties, an affine function of the back-EMF:  u_s = M e + u_0.
///
///   no floating leg:        M = 0,         u_0 = 2/3 Σ d_x v_x
///   one floating leg x:     M = d_x d_xᵀ,  u_0 = j d_x (v_y − v_z)/√3, (x, y, z) cyclic; then di_x/dt = 0
///   two or three floating:  M = I,         u_0 = 0; all currents are zero and stay so
///
/// d_x is the unit vector along phase x, v_x the potential of leg x against the negative rail. [V]
///
/// With a transient inductance that has an axis q (`BackEmf`), di_x/dt = 0 with one floating leg asks for
///   d_xᵀ (I + q qᵀ) (u_s − R_s i_s − e) = 0,
/// which adds  M q qᵀ(v − M v)/(1 + qᵀ M q),  v = e + R_s i_s − u_0.  It is zero where M is 0 or I.
template <class T = double>
struct StatorVoltageMap {
  T gain_alpha{};           ///< M(0,0) [-]
  T gain_cross{};           ///< M(0,1) = M(1,0) [-]
  T gain_beta{};            ///< M(1,1) [-]
  SpaceVector<T> offset{};  ///< u_0 [V]

  /// M x.
  [[nodiscard]] constexpr SpaceVector<T> gain(SpaceVector<T> x) const noexcept SEXTANT_NONBLOCKING {
    return {gain_alpha * x.alpha + gain_cross * x.beta, gain_cross * x.alpha + gain_beta * x.beta};
  }

  /// u_s at a back-EMF. [V]
  [[nodiscard]] constexpr SpaceVector<T> operator()(const BackEmf<T>& emf) const noexcept
      SEXTANT_NONBLOCKING {
    const SpaceVector<T> u_s = gain(emf.e) + offset;
    return emf.has_axis() ? u_s + along_axis(emf) : u_s;
  }

 private:
  /// What the axis of the transient inductance adds. [V]
  [[nodiscard]] constexpr SpaceVector<T> along_axis(const BackEmf<T>& emf) const noexcept
      SEXTANT_NONBLOCKING {
    const SpaceVector<T> v = emf.e + emf.drop - offset;
    const SpaceVector<T> m_q = gain(emf.q);
    return (dot(emf.q, v - gain(v)) / (T(1) + dot(emf.q, m_q))) * m_q;
  }
};

/// Potential of a tied leg against the negative rail; a floating leg counts as low. [V]
template <class T>
[[nodiscard]] constexpr T tied_potential(LegTie tie, T u_dc) noexcept SEXTANT_NONBLOCKING {
  return tie == LegTie::high ? u_dc : T(0);
}

/// The map that holds under the given ties with these potentials of the tied legs against the negative rail
/// [V].
template <class T>
[[nodiscard]] constexpr StatorVoltageMap<T> stator_voltage_map(
    const LegTies& ties, const std::array<T, 3>& v) noexcept SEXTANT_NONBLOCKING {
  switch (floating_legs(ties)) {
    case 0:
      return {T(0), T(0), T(0), clarke(ThreePhase<T>{v[0], v[1], v[2]})};
    case 1:
      break;
    default:
      return {T(1), T(0), T(1), {}};
  }
  const std::size_t x = ties[0] == LegTie::floating ? 0U : ties[1] == LegTie::floating ? 1U : 2U;
  const SpaceVector<T> d = phase_axes<T>[x];
  const T across = std::numbers::inv_sqrt3_v<T> * (v[(x + 1U) % 3U] - v[(x + 2U) % 3U]);
  return {d.alpha * d.alpha, d.alpha * d.beta, d.beta * d.beta, across * rotate_90(d)};
}

}  // namespace sextant
