#pragma once

#include <concepts>

#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/electrical_rates.hpp"
#include "sextant/plant/flux_pair.hpp"
#include "sextant/plant/inverse_inductance.hpp"
#include "sextant/plant/machine_evaluation.hpp"
#include "sextant/plant/machine_slopes.hpp"

namespace sextant {

/// A machine with stator and rotor flux linkages as states; stationary frame, amplitude-invariant. The rotor
/// flux may be that of magnets, which turns with the rotor and keeps its magnitude.
///   evaluate(psi, u_s, omega_m)  all that follows from the state [Wb], the stator voltage [V] and the
///                                mechanical speed [rad/s]; the plant takes currents, torque, slopes, losses
///                                and energy from here alone
/// While legs are off, these count beside:
///   emf(psi, evaluation)         behind the transient inductance
///   stator_flux(i_s, psi_r)      the inverse of the stator current [Wb]
///   inverse_inductance(…)        di_s/dpsi_s at psi_s, psi_r
/// And for integrators:
///   pole_pairs, damping, angle_gain        bound the step of fixed integrators
///   largest_inductance, stator_resistance  bound the flux
/// Everything is inlined: what an integrator does not use of an evaluation is not computed.
template <class Machine, class T>
concept PlantMachine = std::copy_constructible<Machine> &&
                       requires(const Machine& machine, const FluxPair<T>& psi, SpaceVector<T> x, T omega_m) {
                         { machine.evaluate(psi, x, omega_m) } -> std::same_as<MachineEvaluation<T>>;
                         { machine.emf(psi, machine.evaluate(psi, x, omega_m)) } -> std::same_as<BackEmf<T>>;
                         { machine.stator_flux(x, x) } -> std::same_as<SpaceVector<T>>;
                         { machine.inverse_inductance(x, x) } -> std::same_as<InverseInductance<T>>;
                         { machine.damping(x, x) } -> std::same_as<T>;
                         { machine.angle_gain(x, x) } -> std::same_as<T>;
                         { machine.largest_inductance() } -> std::same_as<T>;
                         { machine.stator_resistance() } -> std::same_as<T>;
                         { machine.pole_pairs() } -> std::same_as<T>;
                       };

/// A machine that is linear where `is_linear` says so: its currents are linear in the flux linkages, and
/// these move as `electrical_rates` has it. `torque_slope(psi, dpsi)`: dtau_e/dt where the flux linkages move
/// by dpsi [N·m/s]. An `ExactIntegrator` moves such machines only. Where it is not linear the rates may be
/// any, as they change variables only (`SmoothState`). A class that inherits from a linear machine and is not
/// linear has its own `is_linear`.
template <class Machine, class T>
concept LinearEquations =
    PlantMachine<Machine, T> && requires(const Machine& machine, const FluxPair<T>& psi) {
      { machine.is_linear() } -> std::same_as<bool>;
      { machine.electrical_rates() } -> std::same_as<ElectricalRates<T>>;
      { machine.torque_slope(psi, psi) } -> std::same_as<T>;
    };

/// A machine that gives its part of the plant's Jacobian. That of another one is made of difference
/// quotients.
template <class Machine, class T>
concept DifferentiatedMachine =
    PlantMachine<Machine, T> && requires(const Machine& machine, const FluxPair<T>& psi, T omega_m) {
      { machine.slopes(psi, omega_m) } -> std::same_as<MachineSlopes<T>>;
    };

/// A machine whose resistances [Ω] may change, as a `ThermalNetwork` makes them.
template <class Machine, class T>
concept HeatedMachine = PlantMachine<Machine, T> && requires(const Machine& machine, Machine& heated, T r) {
  { machine.rotor_resistance() } -> std::same_as<T>;
  heated.set_resistances(r, r);
};

}  // namespace sextant
