#pragma once

#include <concepts>
#include <cstddef>
#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/machine_evaluation.hpp"
#include "sextant/plant/plant_inputs.hpp"

namespace sextant {

/// The drive plant's quantities at one instant, for an appended system: those of the machine
/// (`MachineQuantities`) and what is around it. Stationary frame, amplitude-invariant.
template <class T = double>
struct PlantQuantities : MachineQuantities<T> {
  SpaceVector<T> psi_s{};  ///< stator flux linkage [Wb]
  SpaceVector<T> psi_r{};  ///< rotor flux linkage, referred to the stator [Wb]
  SpaceVector<T> u_s{};    ///< stator voltage, in front of the inverter's slope resistance [V]
  T u_dc{};                ///< DC-link voltage [V]
  T i_dc{};                ///< current drawn from the DC link [A]
  T tau_l{};               ///< load torque, opposing positive rotation [N·m]
  T omega_m{};             ///< mechanical speed [rad/s]
  T theta_m{};             ///< mechanical angle, not wrapped [rad]
  T threshold_loss{};      ///< what the thresholds of the inverter's switches and diodes take [W]
  T u_given{};             ///< link voltage of the plant's inputs: u_dc, or that of a `DcLink`'s source [V]
  T tau_given{};           ///< load torque of the plant's inputs: tau_l, or that behind a `Driveline` [N·m]
  T inverter_loss{};       ///< of the plant's inputs, drawn from the link beside i_dc [W]
};

/// A system of differential equations that is driven by the plant and integrated with it: meters, a
/// continuous-time estimator. `derivative(plant, y, dy)` writes dy/dt. Without more it has no effect on the
/// plant; `FeedbackSystem` has.
template <class A, class T>
concept AppendedSystem =
    std::copyable<A> && A::size >= 0 &&
    requires(const A& a, const PlantQuantities<T>& plant, std::span<const T, std::size_t(A::size)> y,
             std::span<T, std::size_t(A::size)> dy) {
      { a.derivative(plant, y, dy) } noexcept;
    };

/// An appended system that declares `static constexpr bool feeds_back = true` acts on the plant: its states
/// decide inputs of the plant that are otherwise given, as a DC link decides the voltage, and a driveline
/// the load torque. `given`: the plant's inputs as they were set; omega_m: speed of the motor [rad/s].
///   begin(y, omega_m)             the states with which the plant begins, the motor at that speed
///   act(y, omega_m, inputs)       changes the given inputs to those that act
///   events(y, omega_m, given, g)  `event_count` functions; an event is a fall through zero
///   on_event(event, y)            the event of one of them has come; may change y
///   settle(y, omega_m, given)     what holds at a state that has not come from the last one by integration,
///                                 or under inputs that have jumped; may change y; true where it changed
///   rate_squared()                the square of how fast its states move at most, for fixed steps [1/s²]
///   is_valid(y)                   false where its equations do not hold
/// Integrators restart where the inverter switches. A system that leaves the link voltage as it is given
/// declares `static constexpr bool keeps_link_voltage = true`.
template <class A, class T>
concept FeedbackSystem =
    AppendedSystem<A, T> && A::feeds_back && A::event_count >= 0 &&
    requires(const A& a, A& changed, std::span<const T, std::size_t(A::size)> y,
             std::span<T, std::size_t(A::size)> z, T omega_m, const PlantInputs<T>& given,
             PlantInputs<T>& inputs, std::span<T, std::size_t(A::event_count)> g) {
      { a.begin(z, omega_m) } noexcept;
      { a.act(y, omega_m, inputs) } noexcept;
      { a.events(y, omega_m, given, g) } noexcept;
      { changed.on_event(0, z) } noexcept;
      { changed.settle(z, omega_m, given) } noexcept -> std::same_as<bool>;
      { a.rate_squared() } noexcept -> std::same_as<T>;
      { a.is_valid(y) } noexcept -> std::same_as<bool>;
    };

/// True for an appended system that declares to be a `FeedbackSystem`.
template <class A>
inline constexpr bool feeds_back = [] {
  if constexpr (requires { A::feeds_back; })
    return A::feeds_back;
  else
    return false;
}();

/// True for an appended system that decides the voltage of the link.
template <class A>
inline constexpr bool moves_link_voltage = [] {
  if constexpr (requires { A::keeps_link_voltage; })
    return !A::keeps_link_voltage;
  else
    return feeds_back<A>;
}();

/// Event functions of an appended system; none without feedback. [-]
template <class A>
inline constexpr int appended_event_count = [] {
  if constexpr (feeds_back<A>)
    return A::event_count;
  else
    return 0;
}();

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
