#include "sextant/comms/status_encoder.hpp"

#include <algorithm>

#include "sextant/core/space_vector.hpp"
#include "sextant_contract.hpp"

namespace sextant {
namespace {

/// The message of the contract.
constexpr contract::Message contract_of(StatusMessage message) noexcept {
  switch (message) {
    case StatusMessage::torque_status:
      return contract::mcu_torque_status;
    case StatusMessage::motion:
      return contract::mcu_motion;
    case StatusMessage::electrical:
      return contract::mcu_electrical;
    case StatusMessage::capability:
      return contract::mcu_capability;
    case StatusMessage::faults:
      return contract::mcu_faults;
    case StatusMessage::real_time:
      return contract::mcu_real_time;
    case StatusMessage::temperatures:
      return contract::mcu_temperatures;
    case StatusMessage::faults_active:
      return contract::mcu_faults_active;
    case StatusMessage::faults_latched:
      return contract::mcu_faults_latched;
    case StatusMessage::identification:
      break;
  }
  return contract::mcu_identification;
}

static_assert(status_message_count == std::size_t(StatusMessage::identification) + 1);

constexpr Identification identification{.software_major = SEXTANT_VERSION_MAJOR,
                                        .software_minor = SEXTANT_VERSION_MINOR,
                                        .software_patch = SEXTANT_VERSION_PATCH};

TorqueStatus torque_status_of(const Telemetry<double>& x) noexcept {
  TorqueStatus status{.torque = x.torque,
                      .torque_reference = x.torque_reference,
                      .state = x.state,
                      .lockout = x.lockout,
                      .command_counter = {}};
  if (x.command_sequence != 0) status.command_counter = x.command_counter;
  return status;
}

FaultReport fault_report_of(const Telemetry<double>& x) noexcept {
  FaultReport report{.first = {}, .total = x.fault_total};
  if (x.latched.any()) report.first = x.first_fault;
  return report;
}

/// Messages of measured or estimated values alone.
bool is_measurement(StatusMessage message) noexcept {
  return message == StatusMessage::motion || message == StatusMessage::electrical;
}

/// Messages that are sent when a fault appears or ends.
bool is_of_faults(StatusMessage message) noexcept {
  return message == StatusMessage::faults || message == StatusMessage::faults_active ||
         message == StatusMessage::faults_latched;
}

EncodedFrame encode_message(StatusMessage message, const Telemetry<double>& x,
                            const StatusExtras& extras) noexcept {
  switch (message) {
    case StatusMessage::torque_status:
      return encode(torque_status_of(x));
    case StatusMessage::motion:
      return encode(Motion{x.omega_m, x.psi_s_magnitude});
    case StatusMessage::electrical:
      return encode(Electrical{x.u_dc, x.i_dc, magnitude(clarke(x.i_abc))});
    case StatusMessage::capability:
      return encode(Capability{x.torque_motoring, x.torque_regenerating, x.derating_cause});
    case StatusMessage::faults:
      return encode(fault_report_of(x));
    case StatusMessage::real_time:
      return encode(extras.real_time);
    case StatusMessage::temperatures:
      return encode(Temperatures{.stator = x.winding_temperature});
    case StatusMessage::faults_active:
      return encode(ActiveFaults{x.active});
    case StatusMessage::faults_latched:
      return encode(LatchedFaults{x.latched});
    case StatusMessage::identification:
      break;
  }
  return encode(identification);
}

}  // namespace

std::int64_t cycle_time_ns(StatusMessage message) noexcept {
  return contract_of(message).cycle_time_ms * 1'000'000;
}

bool is_status_frame(const CanFrame& frame, IdentifierOffset offset) noexcept {
  if (frame.error || frame.extended) return false;
  for (std::size_t i = 0; i < status_message_count; ++i) {
    if (frame.id == offset.id(contract_of(static_cast<StatusMessage>(i)).id)) return true;
  }
  return false;
}

StatusEncoder::StatusEncoder(IdentifierOffset offset) noexcept : offset_{offset} {
  for (std::size_t i = 0; i < status_message_count; ++i) {
    const auto data_id = contract_of(static_cast<StatusMessage>(i)).data_id;
    if (data_id) protectors_[i].emplace(offset.data_id(*data_id));
  }
}

CanFrame StatusEncoder::frame(StatusMessage message, const Telemetry<double>& drive,
                              const StatusExtras& extras) noexcept {
  EncodedFrame encoded = encode_message(message, drive, extras);
  if (encoded.clamped) ++clamped_;
  encoded.frame.id = offset_.id(encoded.frame.id);
  protect(message, encoded.frame);
  return encoded.frame;
}

std::span<const CanFrame> StatusEncoder::due(std::int64_t now_ns, const Telemetry<double>& drive,
                                             const StatusExtras& extras) noexcept {
  if (!started_) next_ns_.fill(now_ns);
  started_ = true;
  const FaultReport faults = fault_report_of(drive);
  const bool faults_changed =
      drive.active != sent_active_ || drive.latched != sent_latched_ || faults != sent_faults_;
  const bool ramp_changed = drive.derating_cause != sent_cause_ &&
                            (is_ramp_to_zero(drive.derating_cause) || is_ramp_to_zero(sent_cause_));
  std::size_t n = 0;
  for (std::size_t i = 0; i < status_message_count; ++i) {
    const auto message = static_cast<StatusMessage>(i);
    const bool changed =
        (faults_changed && is_of_faults(message)) || (ramp_changed && message == StatusMessage::capability);
    if (!is_due(i, now_ns, changed) || (is_measurement(message) && !extras.measured)) continue;
    frames_[n++] = frame(message, drive, extras);
  }
  sent_active_ = drive.active;
  sent_latched_ = drive.latched;
  sent_faults_ = faults;
  sent_cause_ = drive.derating_cause;
  return {frames_.data(), n};
}

bool StatusEncoder::is_due(std::size_t message, std::int64_t now_ns, bool changed) noexcept {
  if (now_ns >= next_ns_[message]) {
    const std::int64_t cycle = cycle_time_ns(static_cast<StatusMessage>(message));
    next_ns_[message] += ((now_ns - next_ns_[message]) / cycle + 1) * cycle;
    return true;
  }
  return changed;
}

std::int64_t StatusEncoder::next_due_ns() const noexcept {
  return *std::ranges::min_element(next_ns_);
}

void StatusEncoder::protect(StatusMessage message, CanFrame& frame) noexcept {
  std::optional<E2eProtector>& protector = protectors_[std::size_t(message)];
  if (!protector) return;
  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  protector->protect(data);
  std::ranges::copy(data, frame.data.begin());
}

}  // namespace sextant
