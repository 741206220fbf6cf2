#pragma once

#include <cstdint>
#include <string>

#include "sextant/config/machine_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/sim/mechanical_load.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant {

enum class ControllerKind : std::uint8_t { direct_torque };

/// True when the controller decides by thresholds alone, as event-exact runs require.
[[nodiscard]] constexpr bool has_continuous_comparators(ControllerKind kind) {
  switch (kind) {
    case ControllerKind::direct_torque:
      return true;
  }
  return false;
}

/// What the shaft is connected to.
struct LoadConfig {
  enum class Kind : std::uint8_t { torque, imposed_speed };
  Kind kind{Kind::torque};
  ProfileParameters torque{};         ///< opposes positive rotation [N·m]
  ProfileParameters imposed_speed{};  ///< mechanical [rad/s]

  /// Empty when usable, else what is wrong.
  [[nodiscard]] std::string validate() const;
  [[nodiscard]] MechanicalLoad::Parameters parameters() const;
};

/// A drive with its simulated plant: what the live drive and a scenario have in common. Parameters that two
/// parts need (control period, actuation delay, machine) occur in the file once.
struct DriveConfig {
  MachineConfig machine{};           ///< as the file gives it; plant.plant.machine is made of it
  MachineConfig machine_estimate{};  ///< how the controller's parameters differ from it
  ControllerKind controller{ControllerKind::direct_torque};
  DirectTorqueController<>::Parameters direct_torque{};
  Drive<>::Parameters drive{};
  double magnetise_timeout_ms{1000};  ///< as the file gives it, or as it follows from the machine [ms]
  SimulatedPowerStage::Parameters plant{};
  LoadConfig load{};
};

/// Sections machine, control, drive, command, capability, protection, plant and load.
void describe(Section root, DriveConfig& config);

/// Empty when the link is below the level at which the drive trips, else a sentence.
[[nodiscard]] std::string validate_link(const DriveConfig& config);

/// Sections plant and load alone.
void describe(Section section, SimulatedPowerStage::Parameters& parameters);
void describe(Section section, LoadConfig& config);

/// True when a file makes the quantity other than zero.
[[nodiscard]] bool is_said(const ProfileParameters& profile);

/// A quantity over time; `unit` of its values and what they may be.
void describe(Section section, ProfileParameters& profile, const char* unit, Range<double> range);

}  // namespace sextant
