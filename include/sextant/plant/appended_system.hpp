#pragma once

#include <concepts>
#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// The drive plant's quantities at one instant, for an appended system. Stationary frame,
/// amplitude-invariant; currents positive into the machine.
template <class T = double>
struct PlantQuantities {
  SpaceVector<T> psi_s{};  ///< stator flux linkage [Wb]
  SpaceVector<T> psi_r{};  ///< rotor flux linkage, referred to the stator [Wb]
  SpaceVector<T> i_s{};    ///< stator current [A]
  SpaceVector<T> i_r{};    ///< rotor current, referred to the stator [A]
  SpaceVector<T> u_s{};    ///< stator voltage, in front of the inverter's slope resistance [V]
  T u_dc{};                ///< DC-link voltage [V]
  T i_dc{};                ///< current drawn from the DC link [A]
  T tau_e{};               ///< electromagnetic torque [N·m]
  T tau_l{};               ///< load torque, opposing positive rotation [N·m]
  T omega_m{};             ///< mechanical speed [rad/s]
  T theta_m{};             ///< mechanical angle, not wrapped [rad]
  T iron_loss{};           ///< of the machine [W]
  T threshold_loss{};      ///< what the thresholds of the inverter's switches and diodes take [W]
};

/// A system of differential equations that is driven by the plant and integrated with it, without an effect
/// on it: meters, a continuous-time estimator. `derivative(plant, y, dy)` writes dy/dt.
template <class A, class T>
concept AppendedSystem =
    std::copyable<A> && A::size >= 0 &&
    requires(const A& a, const PlantQuantities<T>& plant, std::span<const T, std::size_t(A::size)> y,
             std::span<T, std::size_t(A::size)> dy) {
      { a.derivative(plant, y, dy) } noexcept;
    };

/// True for an appended system whose slope does not depend on its own states, as a meter's: it declares
/// `static constexpr bool is_integral = true`. Integrators may take such integrals apart from the rest.
template <class A>
inline constexpr bool is_integral = [] {
  if constexpr (requires { A::is_integral; })
    return A::is_integral;
  else
    return A::size == 0;
}();

/// True for an appended system whose last state integrators with error control follow without a say in their
/// steps: it declares `static constexpr bool last_is_uncontrolled = true`.
template <class A>
inline constexpr bool last_is_uncontrolled = [] {
  if constexpr (requires { A::last_is_uncontrolled; })
    return A::last_is_uncontrolled;
  else
    return false;
}();

/// The appended system that is none.
template <class T = double>
struct NoAppendedSystem {
  static constexpr int size = 0;
  constexpr void derivative(const PlantQuantities<T>&, std::span<const T, 0>,
                            std::span<T, 0>) const noexcept SEXTANT_NONBLOCKING {}
};

}  // namespace sextant
