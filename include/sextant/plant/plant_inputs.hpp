#pragma once

#include "sextant/core/switch_state.hpp"

namespace sextant {

/// What acts on the plant, constant over an integration segment.
template <class T = double>
struct PlantInputs {
  SwitchState state{};        ///< commanded states of the inverter legs
  T u_dc{};                   ///< voltage of the stiff DC link, or of the source of a `DcLink` [V]
  T tau_l{};                  ///< load torque, on the load of a `Driveline`; opposes positive rotation [N·m]
  bool imposed_speed{false};  ///< true: the speed follows speed_slope, whatever the torques
  T speed_slope{};            ///< domega_m/dt where the speed is imposed [rad/s²]
  T inverter_loss{};          ///< drawn from the capacitor of a `DcLink` beside the inverter's current [W]
  friend constexpr bool operator==(const PlantInputs&, const PlantInputs&) noexcept = default;
};

}  // namespace sextant
