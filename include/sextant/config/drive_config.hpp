#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "sextant/config/control_methods.hpp"
#include "sextant/config/machine_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/drive/drive_setup.hpp"
#include "sextant/power_stage/mechanical_load.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {

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
  DriveSetup<> setup{};              ///< as the file gives it
  ControlSetup control{};            ///< what the control methods share, resolved
  std::string controller{"dtc"};     ///< name of the method chosen
  ControlMethods methods{control_methods()};
  MachineConfig monitored_machine{};  ///< how the torque monitor's parameters differ from the controller's
  Drive<>::Parameters drive{};        ///< resolved
  double magnetise_timeout_ms{1000};  ///< the same as printed [ms]
  SimulatedPowerStage::Parameters plant{};
  LoadConfig load{};

  /// Of which circuit the keys of the machine, and those of the controller's, are.
  [[nodiscard]] MachineCircuit machine_circuit() const noexcept {
    return machine.circuit.value_or(MachineCircuit::t);
  }
  [[nodiscard]] MachineCircuit estimate_circuit() const noexcept {
    return machine_estimate.circuit.value_or(machine_circuit());
  }

  /// Of that name. Throws std::logic_error where there is none.
  [[nodiscard]] const ControlMethod& method(std::string_view name) const {
    return named(methods, name, "control method");
  }
  /// The method chosen.
  [[nodiscard]] const ControlMethod& method() const { return method(controller); }
  /// Parameters of the controllers of class `C`, chosen or not. Throws std::logic_error where there are none.
  template <class C>
  [[nodiscard]] const typename C::Parameters& parameters() const {
    return method(C::name).template parameters<C>();
  }
  /// Those of direct torque control.
  [[nodiscard]] const DirectTorqueController<>::Parameters& direct_torque() const {
    return parameters<DirectTorqueController<>>();
  }
};

/// Sections machine, control, drive, command, capability, protection, torque_monitor, plant and load.
void describe(Section root, DriveConfig& config);

/// Checks that the simulated plant does not trip its drive by link, speed or sensors, and that their readings
/// reach beyond the levels at which it trips. counts: whether that matters, once everything has been read.
void check_simulated_plant(const Section& root, const DriveConfig& config, std::function<bool()> counts);

/// Empty when a speed that the load imposes for so long [ns] is not above the level at which the drive trips,
/// else a sentence.
[[nodiscard]] std::string validate_imposed_speed(const DriveConfig& config, const ProfileParameters& speed,
                                                 std::int64_t duration_ns);

/// Section load.
void describe(Section section, LoadConfig& config);

/// True when a file makes the quantity other than zero.
[[nodiscard]] bool is_given(const ProfileParameters& profile);

/// A quantity over time; `unit` of its values and what they may be.
void describe(Section section, ProfileParameters& profile, const char* unit, Range<double> range);

}  // namespace sextant
