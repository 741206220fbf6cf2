#pragma once

#include <cstddef>
#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"

namespace sextant {

/// Energies that have crossed the boundaries of the drive, appended to the plant and integrated with it:
///   dE_dc/dt = u_dc i_dc
///   dE_cs/dt = 3/2 R_s |i_s|² + P_t,   dE_cr/dt = 3/2 R_r |i_r|²
///   dE_m/dt  = tau_e omega_m,   dE_fe/dt = P_fe
/// P_t is what the thresholds of the inverter's switches and diodes take (`ConductionDrops`); R_s has their
/// slope resistance in it, and P_fe is the iron loss (`IronLoss`). None of them is there by default. With the
/// magnetic energy W of `InductionMachine::magnetic_energy` they balance:
///   E_dc = E_cs + E_cr + E_fe + E_m + W(t) − W(0)
/// Integrators with error control follow E_fe without a say of its own error: P_fe is a small and smooth part
/// of what the other integrals are made of.
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

  /// Resistances of the plant's machine, that of the stator with the inverter's slope resistance. [Ω]
  constexpr EnergyMeter(T r_s, T r_r) noexcept : r_s_{r_s}, r_r_{r_r} {}

  /// Replaces them; what has been lost stays. [Ω]
  constexpr void set_resistances(T r_s, T r_r) noexcept SEXTANT_NONBLOCKING {
    r_s_ = r_s;
    r_r_ = r_r;
  }

  /// Powers as above. [W]
  constexpr void derivative(const PlantQuantities<T>& plant, std::span<const T, 5>,
                            std::span<T, 5> power) const noexcept SEXTANT_NONBLOCKING {
    power[dc_link] = plant.u_dc * plant.i_dc;
    power[stator_copper] = T(1.5) * r_s_ * dot(plant.i_s, plant.i_s) + plant.threshold_loss;
    power[rotor_copper] = T(1.5) * r_r_ * dot(plant.i_r, plant.i_r);
    power[mechanical] = plant.tau_e * plant.omega_m;
    power[iron] = plant.iron_loss;
  }

 private:
  T r_s_;  ///< [Ω]
  T r_r_;  ///< [Ω]
};

}  // namespace sextant
