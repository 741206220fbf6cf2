#pragma once

#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/plant/conduction_drops.hpp"
#include "sextant/plant/initial_state.hpp"
#include "sextant/plant/iron_loss_parameters.hpp"
#include "sextant/plant/leakage_saturation.hpp"
#include "sextant/plant/magnetising_points.hpp"
#include "sextant/plant/main_flux.hpp"
#include "sextant/plant/plant_inputs.hpp"
#include "sextant/plant/road_load.hpp"

namespace sextant {

/// What the drive plant is made of.
template <class T = double>
struct DrivePlantParameters {
  InductionMachineParameters<T> machine{};
  SaturationParameters<T> saturation{};  ///< of the machine's main flux; none by default
  IronLossParameters<T> iron_loss{};     ///< of the machine; none by default
  T viscous_friction{};                  ///< B, torque per speed of bearings and fan [N·m·s/rad]
  RoadLoad<T> road_load{};               ///< of the vehicle that the shaft drives; none by default
  ConductionDrops<T> drops{};            ///< of the inverter; none by default
  InitialState<T> initial{};             ///< at rest and without flux by default
  MagnetisingPoints<T> points{};         ///< of the machine's main flux, in the place of `saturation`
  LeakageSaturation<T> leakage{};        ///< of the machine's leakage flux; none by default

  /// The machine with the inverter's slope resistance in series to that of its stator.
  [[nodiscard]] constexpr InductionMachineParameters<T> machine_in_series() const noexcept {
    InductionMachineParameters<T> m = machine;
    m.r_s += drops.slope_resistance;
    return m;
  }
  /// Whether main flux or leakage saturate.
  [[nodiscard]] bool saturates() const noexcept {
    return saturation.acts() || points.acts() || leakage.acts();
  }

  /// nullptr when the values make a plant, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (const char* reason = machine.validate()) return reason;
    if (const char* reason = saturation.validate()) return reason;
    if (const char* reason = points.validate()) return reason;
    if (const char* reason = leakage.validate()) return reason;
    if (const char* reason = validate_curve()) return reason;
    if (const char* reason = iron_loss.validate()) return reason;
    if (const char* reason = iron_loss.validate_with(largest_magnetising_inductance())) return reason;
    if (!(std::isfinite(viscous_friction) && viscous_friction >= T(0))) {
      return "the viscous friction must be finite and not below zero";
    }
    if (const char* reason = road_load.validate()) return reason;
    if (const char* reason = initial.validate()) return reason;
    return drops.validate();
  }

  /// nullptr where main flux and machine fit, else what is wrong; both are valid by themselves.
  [[nodiscard]] const char* validate_curve() const noexcept {
    if (saturation.acts() && points.acts())
      return "the saturation must be given by a knee or by points, not by both";
    if (points.acts() && !(largest_inductance_ratio() <= MagnetisingPoints<T>::largest_ratio))
      return "the points of the saturation make the stator inductance more than ten times that of the "
             "machine";
    return nullptr;
  }

  /// Of the inverse-Γ circuit at small fluxes: at most (1 − sigma) L_su, and L_su where sigma gets small
  /// because the leakage saturates. [H]
  [[nodiscard]] T largest_magnetising_inductance() const noexcept {
    return largest_inductance_ratio() * (leakage.acts() ? machine.l_s() : machine.k_r() * machine.l_m);
  }

 private:
  /// L_s at small fluxes by that of the machine. [-]
  [[nodiscard]] T largest_inductance_ratio() const noexcept {
    if (!points.acts()) return T(1) + saturation.excess(saturation.machine_flux);
    return MainFlux<T>{saturation, points, machine.l_s()}.largest_inductance_ratio();
  }
};

}  // namespace sextant
