#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/derating_cause.hpp"
#include "sextant/core/drive_state.hpp"
#include "sextant/core/fault.hpp"

namespace sextant {

// Status of the drive for the vehicle: one struct a message of configs/interfaces/sextant.dbc, in SI units.

/// MCU_TorqueStatus.
struct TorqueStatus {
  double torque{};                                ///< by the drive's estimator [N·m]
  double torque_reference{};                      ///< output of the command supervision [N·m]
  DriveState state{DriveState::init};             ///< state of the drive
  bool lockout{true};                             ///< no enable is accepted before a valid disable
  std::optional<std::uint8_t> command_counter{};  ///< of the command in force; empty while none has come
};

/// MCU_Motion. The direction follows from the speed as encoded.
struct Motion {
  double omega_m{};          ///< mechanical speed [rad/s]
  double psi_s_magnitude{};  ///< estimated stator flux linkage [Wb]
};

/// MCU_Electrical.
struct Electrical {
  double u_dc{};           ///< DC-link voltage [V]
  double i_dc{};           ///< DC-link current, positive into the inverter [A]
  double i_s_magnitude{};  ///< stator current vector, the peak of the phase current [A]
};

/// MCU_Capability.
struct Capability {
  double torque_motoring{};      ///< available magnitude [N·m]
  double torque_regenerating{};  ///< available magnitude [N·m]
  DeratingCause cause{DeratingCause::none};
};

/// MCU_Faults.
struct FaultReport {
  std::optional<Fault> first{};  ///< the first that latched since the last reset; empty for none
  std::uint64_t total{};         ///< latched faults since start [-]
  friend bool operator==(const FaultReport&, const FaultReport&) noexcept = default;
};

/// MCU_FaultsActive.
struct ActiveFaults {
  FaultSet faults{};  ///< present
};

/// MCU_FaultsLatched.
struct LatchedFaults {
  FaultSet faults{};  ///< since the last reset
};

/// MCU_RealTime.
struct RealTimeReport {
  std::uint64_t periods_missed{};     ///< control periods missed since start [-]
  double worst_execution_time{};      ///< longest execution time of a wake-up in the last second [s]
  double worst_wake_latency{};        ///< largest wake-up latency in the last second [s]
  std::uint64_t telemetry_dropped{};  ///< control periods lost to telemetry since start [-]
};

/// MCU_Temperatures. An empty value, neither measured nor modelled, is sent as "not available".
struct Temperatures {
  std::optional<double> stator{};    ///< winding [°C]
  std::optional<double> rotor{};     ///< cage [°C]
  std::optional<double> inverter{};  ///< hottest switch [°C]
};

/// MCU_Identification. The codec adds the version of the contract.
struct Identification {
  std::uint8_t software_major{};
  std::uint8_t software_minor{};
  std::uint8_t software_patch{};
};

}  // namespace sextant
