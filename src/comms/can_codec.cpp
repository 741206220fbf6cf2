#include "sextant/comms/can_codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "sextant_contract.hpp"

namespace sextant {
namespace {

using contract::Signal;

constexpr std::size_t frame_length = 8;

/// Scales values into raw signals; `clamped` is true once one was beyond its range.
class Packer {
 public:
  template <class Raw>
  Raw operator()(const Signal<Raw>& signal, double value) noexcept {
    const double wanted = std::isnan(value) ? 0.0 : value;
    const double sent = std::clamp(wanted, signal.minimum, signal.maximum);
    const Raw raw = signal.encode(sent);
    if (std::isnan(value) || sent != wanted || !signal.is_in_range(raw)) clamped_ = true;
    return raw;
  }

  template <class Raw>
  Raw operator()(const Signal<Raw>& signal, std::optional<double> value, Raw not_available) noexcept {
    return value ? (*this)(signal, *value) : not_available;
  }

  /// A counter or worst case, for which the contract defines the maximum as "that much or more".
  template <class Raw>
  Raw saturated(const Signal<Raw>& signal, double value) noexcept {
    return (*this)(signal, value > signal.maximum ? signal.maximum : value);
  }

  [[nodiscard]] bool clamped() const noexcept { return clamped_; }

 private:
  bool clamped_{false};
};

template <class Message>
EncodedFrame frame_of(std::uint32_t id, const Message& message,
                      int (*pack)(std::uint8_t*, const Message*, std::size_t), bool clamped) noexcept {
  EncodedFrame result{.frame = {.id = id, .length = frame_length}, .clamped = clamped};
  pack(result.frame.data.data(), &message, frame_length);
  return result;
}

/// Sets the signal of each fault of the set.
template <class Message, std::size_t n>
void mark(Message& message, const std::array<contract::FaultSignal<Message>, n>& signals,
          FaultSet faults) noexcept {
  for (const auto& x : signals) message.*x.signal = faults.test(x.fault) ? 1 : 0;
}

}  // namespace

// The enumerations have the values of the contract.
static_assert(int(DriveState::init) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_INIT_CHOICE);
static_assert(int(DriveState::standby) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_STANDBY_CHOICE);
static_assert(int(DriveState::ready) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_READY_CHOICE);
static_assert(int(DriveState::magnetising) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_MAGNETISING_CHOICE);
static_assert(int(DriveState::torque) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_TORQUE_CHOICE);
static_assert(int(DriveState::derated) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_DERATED_CHOICE);
static_assert(int(DriveState::fault) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_FAULT_CHOICE);
static_assert(int(DriveState::shutdown) == SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_SHUTDOWN_CHOICE);
static_assert(int(DeratingCause::none) == SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_NONE_CHOICE);
static_assert(int(DeratingCause::current_limit) ==
              SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_CURRENT_LIMIT_CHOICE);
static_assert(int(DeratingCause::voltage_limit) ==
              SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_VOLTAGE_LIMIT_CHOICE);
static_assert(int(DeratingCause::temperature) == SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_TEMPERATURE_CHOICE);
static_assert(int(DeratingCause::dc_link_low) == SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_DC_LINK_LOW_CHOICE);
static_assert(int(DeratingCause::dc_link_high) == SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_DC_LINK_HIGH_CHOICE);
static_assert(int(DeratingCause::gates_are_off) == SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_GATES_OFF_CHOICE);
static_assert(int(DeratingCause::command_timeout) ==
              SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_COMMAND_TIMEOUT_CHOICE);
static_assert(int(DeratingCause::status_timeout) ==
              SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_STATUS_TIMEOUT_CHOICE);
static_assert(int(DeratingCause::shutdown) == SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_SHUTDOWN_CHOICE);

EncodedFrame encode(const TorqueStatus& x) noexcept {
  Packer pack;
  sextant_mcu_torque_status_t m{};
  m.torque_estimated = pack(contract::mcu_torque_status_torque_estimated, x.torque);
  m.torque_reference = pack(contract::mcu_torque_status_torque_reference, x.torque_reference);
  m.drive_state = pack(contract::mcu_torque_status_drive_state, double(x.state));
  m.lockout = x.lockout ? 1 : 0;
  m.command_counter = pack(contract::mcu_torque_status_command_counter,
                           x.command_counter.value_or(SEXTANT_MCU_TORQUE_STATUS_COMMAND_COUNTER_NONE_CHOICE));
  return frame_of(SEXTANT_MCU_TORQUE_STATUS_FRAME_ID, m, sextant_mcu_torque_status_pack, pack.clamped());
}

EncodedFrame encode(const Motion& x) noexcept {
  constexpr double rpm_per_rad_s = 30.0 / std::numbers::pi;
  Packer pack;
  sextant_mcu_motion_t m{};
  m.speed = pack(contract::mcu_motion_speed, x.omega_m * rpm_per_rad_s);
  m.flux_magnitude = pack(contract::mcu_motion_flux_magnitude, x.psi_s_magnitude);
  m.direction = m.speed > 0   ? SEXTANT_MCU_MOTION_DIRECTION_FORWARD_CHOICE
                : m.speed < 0 ? SEXTANT_MCU_MOTION_DIRECTION_REVERSE_CHOICE
                              : SEXTANT_MCU_MOTION_DIRECTION_STANDSTILL_CHOICE;
  return frame_of(SEXTANT_MCU_MOTION_FRAME_ID, m, sextant_mcu_motion_pack, pack.clamped());
}

EncodedFrame encode(const Electrical& x) noexcept {
  Packer pack;
  sextant_mcu_electrical_t m{};
  m.dc_voltage = pack(contract::mcu_electrical_dc_voltage, x.u_dc);
  m.dc_current = pack(contract::mcu_electrical_dc_current, x.i_dc);
  m.phase_current_rms =
      pack(contract::mcu_electrical_phase_current_rms, x.i_s_magnitude / std::numbers::sqrt2);
  return frame_of(SEXTANT_MCU_ELECTRICAL_FRAME_ID, m, sextant_mcu_electrical_pack, pack.clamped());
}

EncodedFrame encode(const Capability& x) noexcept {
  Packer pack;
  sextant_mcu_capability_t m{};
  m.torque_motoring = pack(contract::mcu_capability_torque_motoring, x.torque_motoring);
  m.torque_regenerating = pack(contract::mcu_capability_torque_regenerating, x.torque_regenerating);
  m.derating_cause = pack(contract::mcu_capability_derating_cause, double(x.cause));
  return frame_of(SEXTANT_MCU_CAPABILITY_FRAME_ID, m, sextant_mcu_capability_pack, pack.clamped());
}

EncodedFrame encode(const FaultReport& x) noexcept {
  Packer pack;
  sextant_mcu_faults_t m{};
  m.first_fault = x.first ? pack(contract::mcu_faults_first_fault, double(*x.first))
                          : std::uint8_t{SEXTANT_MCU_FAULTS_FIRST_FAULT_NONE_CHOICE};
  m.fault_total = pack.saturated(contract::mcu_faults_fault_total, double(x.total));
  return frame_of(SEXTANT_MCU_FAULTS_FRAME_ID, m, sextant_mcu_faults_pack, pack.clamped());
}

EncodedFrame encode(const ActiveFaults& x) noexcept {
  sextant_mcu_faults_active_t m{};
  mark(m, contract::mcu_faults_active_signals, x.faults);
  return frame_of(SEXTANT_MCU_FAULTS_ACTIVE_FRAME_ID, m, sextant_mcu_faults_active_pack, false);
}

EncodedFrame encode(const LatchedFaults& x) noexcept {
  sextant_mcu_faults_latched_t m{};
  mark(m, contract::mcu_faults_latched_signals, x.faults);
  return frame_of(SEXTANT_MCU_FAULTS_LATCHED_FRAME_ID, m, sextant_mcu_faults_latched_pack, false);
}

EncodedFrame encode(const RealTimeReport& x) noexcept {
  constexpr double us_per_s = 1e6;
  Packer pack;
  sextant_mcu_real_time_t m{};
  m.periods_missed = pack.saturated(contract::mcu_real_time_periods_missed, double(x.periods_missed));
  m.worst_execution_time =
      pack.saturated(contract::mcu_real_time_worst_execution_time, x.worst_execution_time * us_per_s);
  m.worst_wake_latency =
      pack.saturated(contract::mcu_real_time_worst_wake_latency, x.worst_wake_latency * us_per_s);
  m.telemetry_dropped =
      pack.saturated(contract::mcu_real_time_telemetry_dropped, double(x.telemetry_dropped));
  return frame_of(SEXTANT_MCU_REAL_TIME_FRAME_ID, m, sextant_mcu_real_time_pack, pack.clamped());
}

EncodedFrame encode(const Temperatures& x) noexcept {
  Packer pack;
  sextant_mcu_temperatures_t m{};
  m.stator_temperature = pack(contract::mcu_temperatures_stator_temperature, x.stator,
                              contract::mcu_temperatures_stator_temperature_not_available);
  m.rotor_temperature = pack(contract::mcu_temperatures_rotor_temperature, x.rotor,
                             contract::mcu_temperatures_rotor_temperature_not_available);
  m.inverter_temperature = pack(contract::mcu_temperatures_inverter_temperature, x.inverter,
                                contract::mcu_temperatures_inverter_temperature_not_available);
  return frame_of(SEXTANT_MCU_TEMPERATURES_FRAME_ID, m, sextant_mcu_temperatures_pack, pack.clamped());
}

EncodedFrame encode(const Identification& x) noexcept {
  sextant_mcu_identification_t m{};
  m.contract_major = contract::version_major;
  m.contract_minor = contract::version_minor;
  m.software_major = x.software_major;
  m.software_minor = x.software_minor;
  m.software_patch = x.software_patch;
  return frame_of(SEXTANT_MCU_IDENTIFICATION_FRAME_ID, m, sextant_mcu_identification_pack, false);
}

EncodedFrame encode(const TorqueCommand<double>& x) noexcept {
  Packer pack;
  sextant_vcu_torque_command_t m{};
  m.torque_request = pack(contract::vcu_torque_command_torque_request, x.torque);
  m.torque_limit = pack(contract::vcu_torque_command_torque_limit, x.torque_limit);
  m.enable = x.enable ? 1 : 0;
  m.fault_reset = x.fault_reset ? 1 : 0;
  return frame_of(SEXTANT_VCU_TORQUE_COMMAND_FRAME_ID, m, sextant_vcu_torque_command_pack, pack.clamped());
}

CommandIdentity identify_command(const CanFrame& frame, IdentifierOffset offset) noexcept {
  if (frame.id != command_id(offset) || frame.error) return CommandIdentity::other;
  if (frame.extended) return CommandIdentity::extended_alias;
  if (frame.fd) return CommandIdentity::fd_alias;
  if (frame.rtr) return CommandIdentity::remote;
  if (frame.length != SEXTANT_VCU_TORQUE_COMMAND_LENGTH) return CommandIdentity::wrong_length;
  return CommandIdentity::command;
}

DecodedCommand decode_command(const CanFrame& frame) noexcept {
  sextant_vcu_torque_command_t m{};
  if (sextant_vcu_torque_command_unpack(&m, frame.data.data(), frame_length) != 0) return {};
  const auto& torque = contract::vcu_torque_command_torque_request;
  const auto& limit = contract::vcu_torque_command_torque_limit;
  return {.command = {.torque = torque.decode(m.torque_request),
                      .torque_limit = limit.decode(m.torque_limit),
                      .enable = m.enable != 0,
                      .fault_reset = m.fault_reset != 0,
                      .counter = m.counter},
          .in_range = torque.is_in_range(m.torque_request) && limit.is_in_range(m.torque_limit)};
}

std::array<CanIdentifier, 3> drive_identifiers(IdentifierOffset offset) noexcept {
  return {{{.id = command_id(offset)},
           {.id = command_id(offset), .extended = true},
           {.id = offset.id(SEXTANT_MCU_TORQUE_STATUS_FRAME_ID)}}};
}

std::uint32_t command_id(IdentifierOffset offset) noexcept {
  return offset.id(SEXTANT_VCU_TORQUE_COMMAND_FRAME_ID);
}
std::uint16_t command_data_id(IdentifierOffset offset) noexcept {
  return offset.data_id(contract::vcu_torque_command_data_id);
}

std::optional<TorqueStatus> decode_torque_status(const CanFrame& frame, IdentifierOffset offset) noexcept {
  const bool is_other = frame.error || frame.extended || frame.fd || frame.rtr ||
                        frame.id != offset.id(SEXTANT_MCU_TORQUE_STATUS_FRAME_ID) ||
                        frame.length != SEXTANT_MCU_TORQUE_STATUS_LENGTH;
  sextant_mcu_torque_status_t m{};
  if (is_other || sextant_mcu_torque_status_unpack(&m, frame.data.data(), frame_length) != 0) return {};
  if (!contract::mcu_torque_status_drive_state.is_in_range(m.drive_state)) return {};
  TorqueStatus status{
      .torque = contract::mcu_torque_status_torque_estimated.decode(m.torque_estimated),
      .torque_reference = contract::mcu_torque_status_torque_reference.decode(m.torque_reference),
      .state = static_cast<DriveState>(m.drive_state),
      .lockout = m.lockout != 0,
      .command_counter = {}};
  if (m.command_counter != SEXTANT_MCU_TORQUE_STATUS_COMMAND_COUNTER_NONE_CHOICE) {
    status.command_counter = m.command_counter;
  }
  return status;
}

std::uint16_t torque_status_data_id(IdentifierOffset offset) noexcept {
  return offset.data_id(contract::mcu_torque_status_data_id);
}

}  // namespace sextant
