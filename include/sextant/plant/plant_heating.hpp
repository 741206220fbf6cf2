#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/thermal_network.hpp"
#include "sextant/plant/thermal_parameters.hpp"

namespace sextant {

/// Heats a thermal network by the losses of a plant with an energy meter, and gives the plant the resistances
/// that its temperatures make:
///   winding  3/2 R_s |i_s|²,   rotor  3/2 R_r |i_r|²,   housing  P_fe + B omega_m²
///   R_s(ϑ) = R_s (1 + α_s (ϑ − ϑ_ref)),   R_r likewise
/// What the inverter loses heats none of them. The meter's last states are the plant's last ones.
///
/// Temperatures are slow beside fluxes and speed. They stand still over a step of
/// `ThermalParameters::step_ns`, over which the plant moves with the resistances of its beginning; then the
/// network moves by the energies that the plant has lost, as if at constant power. So the plant's resistances
/// lag by half a step in the mean: the temperature that they belong to is wrong by h/2 dϑ/dt, of order 1 in
/// h. A winding that heats by 10 K/s has R_s 0.02 % too small with the default step of 10 ms. No energy is
/// lost: what the meter counts as loss is what the network gets as heat.
template <class Plant>
class PlantHeating {
 public:
  using T = typename Plant::Scalar;

  /// Parameters valid, and those of the plant, which is as after construction and gets the resistances of the
  /// first temperatures.
  PlantHeating(const DrivePlantParameters<T>& plant_parameters, const ThermalParameters<T>& parameters,
               Plant& plant)
      : parameters_{parameters},
        network_{parameters},
        r_s_{plant_parameters.machine.r_s},
        r_r_{plant_parameters.machine.r_r},
        viscous_friction_{plant_parameters.viscous_friction} {
    static_assert(has_part<EnergyMeter<T>, typename Plant::AppendedType>, "the plant needs an energy meter");
    set_resistances(plant);
    read_meter(plant);
  }

  /// The plant is about to move over a piece of its time.
  void begin_piece(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    omega_ = plant.omega_m();
    threshold_power_ = plant.drops().threshold_loss(plant.i_s());
  }
  /// It has moved. Over a piece the speed runs in a line, and what the inverter's thresholds take does, too.
  void end_piece(const Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING {
    const T h = seconds(duration_ns);
    const T omega = plant.omega_m();
    friction_ += viscous_friction_ * h / T(3) * (omega_ * omega_ + omega_ * omega + omega * omega);
    threshold_ += h / T(2) * (threshold_power_ + plant.drops().threshold_loss(plant.i_s()));
    elapsed_ns_ += duration_ns;
  }

  /// Moves temperatures and resistances where the step is over; true where it is, and the plant's integrator
  /// is to be reset.
  [[nodiscard]] bool step(Plant& plant) noexcept SEXTANT_NONBLOCKING {
    if (elapsed_ns_ < parameters_.step_ns) return false;
    network_.step(heat(plant), seconds(elapsed_ns_));
    set_resistances(plant);
    read_meter(plant);
    friction_ = threshold_ = T(0);
    elapsed_ns_ = 0;
    return true;
  }

  /// As they have been since the last step. [°C]
  [[nodiscard]] ThermalNodes<T> temperatures() const noexcept SEXTANT_NONBLOCKING {
    return network_.temperatures();
  }

 private:
  static constexpr int meter = Plant::size - EnergyMeter<T>::size;

  [[nodiscard]] static T seconds(std::int64_t ns) noexcept SEXTANT_NONBLOCKING { return T(ns) * T(1e-9); }

  /// Since the last step. The meter counts the winding together with the inverter. [J]
  [[nodiscard]] ThermalNodes<T> heat(const Plant& plant) const noexcept SEXTANT_NONBLOCKING {
    const auto gone = [this, &plant](int index) noexcept SEXTANT_NONBLOCKING {
      return plant.state()[meter + index] - meter_[std::size_t(index)];
    };
    const T r_s_and_slope = plant.machine().stator_resistance();
    const T winding_share = (r_s_and_slope - plant.drops().slope_resistance) / r_s_and_slope;
    return {winding_share * (gone(EnergyMeter<T>::stator_copper) - threshold_),
            gone(EnergyMeter<T>::rotor_copper), gone(EnergyMeter<T>::iron) + friction_};
  }
  void read_meter(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    for (std::size_t k = 0; k < meter_.size(); ++k) meter_[k] = plant.state()[meter + int(k)];
  }
  void set_resistances(Plant& plant) noexcept SEXTANT_NONBLOCKING {
    const ThermalNodes<T> t = network_.temperatures();
    plant.set_resistances(r_s_ * parameters_.winding_ratio(t.winding) + plant.drops().slope_resistance,
                          r_r_ * parameters_.rotor_ratio(t.rotor));
  }

  ThermalParameters<T> parameters_;
  ThermalNetwork<T> network_;
  T r_s_;                       ///< at the reference temperature [Ω]
  T r_r_;                       ///< the same [Ω]
  T viscous_friction_;          ///< [N·m·s/rad]
  T omega_{};                   ///< at the beginning of the piece [rad/s]
  T threshold_power_{};         ///< the same [W]
  T friction_{};                ///< lost in bearings and fan since the last step [J]
  T threshold_{};               ///< lost in the inverter's thresholds since then [J]
  std::int64_t elapsed_ns_{0};  ///< since then [ns]
  std::array<T, std::size_t(EnergyMeter<T>::size)> meter_{};  ///< its readings there [J]
};

}  // namespace sextant
