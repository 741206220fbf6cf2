#pragma once

#include "sextant/core/space_vector.hpp"
#include "sextant/plant/flux_pair.hpp"

namespace sextant {

/// What follows from a machine's flux linkages and its speed, whatever the stator voltage is. Stationary
/// frame, amplitude-invariant; currents positive into the machine.
template <class T = double>
struct MachineQuantities {
  SpaceVector<T> i_s{};  ///< stator current [A]
  SpaceVector<T> i_r{};  ///< rotor current, referred to the stator [A]
  T tau_e{};             ///< electromagnetic torque, positive in the direction of positive speed [N·m]
  T stator_loss{};       ///< in the stator's resistance, 3/2 R_s |i_s|² [W]
  T rotor_loss{};        ///< in the rotor's resistance, 3/2 R_r |i_r|² [W]
  T iron_loss{};         ///< [W]
};

/// A machine at one instant (`PlantMachine::evaluate`). The stator voltage u_s counts for dpsi.s alone. With
///   3/2 u_s · i_s = stator_loss + rotor_loss + iron_loss + tau_e omega_m + d(field_energy)/dt
/// the energies of the plant balance.
template <class T = double>
struct MachineEvaluation : MachineQuantities<T> {
  FluxPair<T> dpsi{};  ///< slopes of the flux linkages, that of the stator u_s − R_s i_s [V]
  T field_energy{};    ///< stored in the magnetic field [J]
};

}  // namespace sextant
