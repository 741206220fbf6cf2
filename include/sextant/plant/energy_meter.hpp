#pragma once

#include <cstddef>
#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"

namespace sextant {

/// Energies that have crossed the boundaries of the drive, appended to the plant and integrated with it:
///   dE_dc/dt = u_dc i_dc
///   dE_cs/dt = stator_loss + P_t,   dE_cr/dt = rotor_loss
///   dE_m/dt  = tau_e omega_m,       dE_fe/dt = iron_loss
/// by the losses that the machine has at each instant (`MachineQuantities`). P_t is what the thresholds of
/// the inverter's switches and diodes take (`ConductionDrops`); their slope resistance is in the stator loss.
/// None of them is there by default. With the magnetic energy W, `MachineEvaluation::field_energy`, they
/// balance:
///   E_dc = E_cs + E_cr + E_fe + E_m + W(t) − W(0)
/// Integrators with error control follow E_fe without a say of its own error: its power is a small and smooth
/// part of what the other integrals are made of.
template <class T = double>
class EnergyMeter {
 public:
  static constexpr int size = 5;
  static constexpr bool last_is_uncontrolled = true;
  static constexpr bool is_integral = true;
  enum Index : std::size_t {
    dc_link = 0,        ///< drawn from the DC link [J]
    stator_copper = 1,  ///< lost in the stator resistance, and in switches and diodes [J]
    rotor_copper = 2,   ///< lost in the rotor resistance [J]
    mechanical = 3,     ///< work of the electromagnetic torque on the shaft [J]
    iron = 4            ///< lost in the iron [J]
  };

  /// Powers as above. [W]
  constexpr void derivative(const PlantQuantities<T>& plant, std::span<const T, 5>,
                            std::span<T, 5> power) const noexcept SEXTANT_NONBLOCKING {
    power[dc_link] = plant.u_dc * plant.i_dc;
    power[stator_copper] = plant.stator_loss + plant.threshold_loss;
    power[rotor_copper] = plant.rotor_loss;
    power[mechanical] = plant.tau_e * plant.omega_m;
    power[iron] = plant.iron_loss;
  }
};

}  // namespace sextant
