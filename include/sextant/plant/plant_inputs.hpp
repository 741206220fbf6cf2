#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// What holds the main contactor of a `DcLink` with a pre-charge resistor.
enum class Contactor : std::uint8_t {
  automatic,  ///< nothing: it closes once the link is charged, and stays closed
  held_open,  ///< it does not close, or has opened
  welded      ///< it is closed, charged or not
};

/// What acts on the plant, constant over an integration segment.
template <class T = double>
struct PlantInputs {
  SwitchState state{};        ///< commanded states of the inverter legs
  T u_dc{};                   ///< voltage of the stiff DC link, or of the source of a `DcLink` [V]
  T tau_l{};                  ///< load torque, on the load of a `Driveline`; opposes positive rotation [N·m]
  bool imposed_speed{false};  ///< true: the speed follows speed_slope, whatever the torques
  T speed_slope{};            ///< domega_m/dt where the speed is imposed [rad/s²]
  T inverter_loss{};          ///< drawn from the capacitor of a `DcLink` beside the inverter's current [W]
  /// In the place of states, which are those at the end: mean potentials of the legs, as shares of the link's
  /// voltage (`mean_duties`); empty: the states act. [-]
  std::optional<ThreePhase<T>> duties{};
  Contactor contactor{Contactor::automatic};  ///< of a `DcLink` that has one
  friend constexpr bool operator==(const PlantInputs&, const PlantInputs&) noexcept = default;
};

}  // namespace sextant
