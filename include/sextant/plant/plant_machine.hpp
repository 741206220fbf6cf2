#pragma once

#include <concepts>

#include "sextant/core/space_vector.hpp"
#include "sextant/plant/induction_machine.hpp"

namespace sextant {

/// The equations of a machine with stator and rotor flux linkages as states, as `InductionMachine` documents
/// them; stationary frame, amplitude-invariant. `electrical_rates` and `parameters` bound the step of fixed
/// integrators and the flux: those of the linear machine that is fastest. `emf` and `stator_flux` count while
/// legs are off. `is_linear`: the currents are linear in the flux linkages, as `electrical_rates` and
/// `parameters` have it; an `ExactIntegrator` takes such machines only. A class that inherits from a linear
/// machine and is not linear declares its own `is_linear`.
template <class Machine, class T>
concept PlantMachine =
    std::copy_constructible<Machine> && std::same_as<decltype(Machine::is_linear), const bool> &&
    requires(const Machine& machine, SpaceVector<T> x, T omega_m) {
      { machine.stator_current(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.rotor_current(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.stator_flux(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.stator_flux_derivative(x, x) } -> std::same_as<SpaceVector<T>>;
      { machine.rotor_flux_derivative(x, x, omega_m) } -> std::same_as<SpaceVector<T>>;
      { machine.emf(x) } -> std::same_as<SpaceVector<T>>;
      { machine.torque(x, x) } -> std::same_as<T>;
      { machine.magnetic_energy(x, x) } -> std::same_as<T>;
      { machine.electrical_rates() } -> std::same_as<ElectricalRates<T>>;
      { machine.parameters() } -> std::convertible_to<const InductionMachineParameters<T>&>;
    };

}  // namespace sextant
