#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/derating_cause.hpp"
#include "sextant/core/drive_state.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// The drive's record of one control period. Trivially copyable: threads share it by value.
template <class T = double>
struct Telemetry {
  std::int64_t t_ns{};     ///< beginning of the control period, on the drive's clock [ns]
  ThreePhase<T> i_abc{};   ///< measured phase currents [A]
  T u_dc{};                ///< measured DC-link voltage [V]
  T omega_m{};             ///< measured mechanical speed [rad/s]
  T i_dc{};                ///< DC-link current, mean of the period that ended, from pattern and currents [A]
  SpaceVector<T> psi_s{};  ///< estimated stator flux linkage, stationary frame [Wb]
  T psi_s_magnitude{};     ///< its magnitude [Wb]
  T torque{};              ///< estimated torque [N·m]
  T r_s{};                 ///< stator resistance in use by the controller; 0 where it tells none [Ω]
  T r_r{};                 ///< the same of the rotor [Ω]
  T l_m{};                 ///< the same of the magnetising inductance [H]
  T r_s_deviation{};       ///< relative standard deviation of `r_s`; 0 where the controller tells none [-]
  T r_r_deviation{};       ///< the same of `r_r` [-]
  T l_m_deviation{};       ///< the same of `l_m` [-]
  T torque_monitored{};    ///< mean torque by the torque monitor; zero without torque production [N·m]
  T torque_requested{};    ///< requested torque, as received [N·m]
  T torque_reference{};    ///< output of the command supervision [N·m]
  /// What link and machine have let the torque reach; `torque_reference` where it does not lag that. [N·m]
  T torque_reached{};
  T torque_motoring{};      ///< available torque for motoring, magnitude [N·m]
  T torque_regenerating{};  ///< available torque for regenerating, magnitude [N·m]
  /// Of the stator, measured or by the thermal model; empty without either. [°C]
  std::optional<T> winding_temperature{};
  FaultSet active{};            ///< faults present in this period
  FaultSet latched{};           ///< faults since the last reset
  std::uint32_t fault_total{};  ///< latched faults since start
  Fault first_fault{};          ///< the first that latched; meaningful while `latched.any()`
  GatePattern pattern{};        ///< of the coming period
  /// Control periods so far, with legs driven, that the checks of currents and speed left out.
  std::uint64_t unchecked_periods{};
  std::int64_t command_received_ns{};  ///< receive time of the command in force [ns]
  std::uint64_t command_sequence{};    ///< accepted frames so far; 0 while none has come
  std::uint32_t command_rejected{};    ///< frames dropped so far
  std::uint8_t command_counter{};      ///< E2E counter of the command in force
  std::uint8_t sector{};               ///< sector of the stator flux, 1…6; 0 without flux
  DriveState state{DriveState::init};
  DeratingCause derating_cause{DeratingCause::gates_are_off};  ///< what limits the torque
  bool lockout{true};  ///< no enable is accepted before a valid disable
};

}  // namespace sextant
