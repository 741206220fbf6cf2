#pragma once

#include <concepts>

#include "sextant/core/space_vector.hpp"
#include "sextant/plant/induction_machine.hpp"

namespace sextant {

/// The equations of a machine with stator and rotor flux linkages as states, as `InductionMachine` documents
/// them; stationary frame, amplitude-invariant. The rotor flux may be that of magnets, which turns with the
/// rotor and keeps its magnitude. `pole_pairs`, `damping` and `angle_gain` bound the step of fixed
/// integrators, `largest_inductance` and `stator_resistance` the flux. `emf` and `stator_flux` count while
/// legs are off, `inverse_inductance` where they are tied; `iron_branch` where `has_iron_loss`, and rotor
/// current and torque are then those before the iron's share. `is_linear`: the currents are linear in the
/// flux linkages, as `electrical_rates` has it; an `ExactIntegrator` moves such machines only. Others may
/// have any rates, as those change variables only (`SmoothState`). A class that inherits from a linear
/// machine and is not linear has its own `is_linear`.
template <class Machine, class T>
concept PlantMachine =
    std::copy_constructible<Machine> && requires(const Machine& machine, SpaceVector<T> x, T omega_m) {
      { machine.stator_current(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.rotor_current(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.stator_flux(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.stator_flux_derivative(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.rotor_flux_derivative(x, x, omega_m) } -> std::same_as<SpaceVector<T>>;
      { machine.emf(x, x, x, x) } -> std::same_as<BackEmf<T>>;
      { machine.torque(x, x) } -> std::same_as<T>;
      { machine.magnetic_energy(x, x) } -> std::same_as<T>;
      { machine.is_linear() } -> std::same_as<bool>;
      { machine.has_iron_loss() } -> std::same_as<bool>;
      { machine.iron_branch(x, x, omega_m).i_r } -> std::convertible_to<SpaceVector<T>>;
      { machine.iron_branch(x, x, omega_m).torque } -> std::convertible_to<T>;
      { machine.iron_branch(x, x, omega_m).power } -> std::convertible_to<T>;
      { machine.inverse_inductance(x, x).across } -> std::convertible_to<T>;
      { machine.inverse_inductance(x, x).added_along } -> std::convertible_to<T>;
      { machine.damping(x, x) } -> std::same_as<T>;
      { machine.largest_inductance() } -> std::same_as<T>;
      { machine.electrical_rates() } -> std::same_as<ElectricalRates<T>>;
      { machine.pole_pairs() } -> std::same_as<T>;
      { machine.stator_resistance() } -> std::same_as<T>;
      { machine.angle_gain(x, x) } -> std::same_as<T>;
    };

/// A machine with the equations of the induction machine, whose `parameters`, `iron_slopes` where
/// `has_iron_loss`, and `added_leakage` where `has_saturated_leakage`, make the Jacobian of the plant; that
/// of another one is made of difference quotients.
template <class Machine, class T>
concept InductionEquations = PlantMachine<Machine, T> && requires(const Machine& machine, SpaceVector<T> x) {
  { machine.iron_slopes(x, x).along } -> std::convertible_to<T>;
  { machine.iron_slopes(x, x).across } -> std::convertible_to<T>;
  { machine.iron_slopes(x, x).by_flux } -> std::convertible_to<T>;
  { machine.parameters() } -> std::convertible_to<const InductionMachineParameters<T>&>;
  { machine.has_saturated_leakage() } -> std::same_as<bool>;
  { machine.added_leakage(x, x) } -> std::same_as<InverseInductance<T>>;
};

}  // namespace sextant
