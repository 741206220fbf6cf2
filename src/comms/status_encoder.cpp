#include "sextant/comms/status_encoder.hpp"

#include <algorithm>

#include "sextant/core/space_vector.hpp"
#include "sextant_contract.hpp"

namespace sextant {
namespace {

constexpr std::array<unsigned, status_message_count> cycle_times_ms{
    SEXTANT_MCU_TORQUE_STATUS_CYCLE_TIME_MS, SEXTANT_MCU_MOTION_CYCLE_TIME_MS,
    SEXTANT_MCU_ELECTRICAL_CYCLE_TIME_MS,    SEXTANT_MCU_CAPABILITY_CYCLE_TIME_MS,
    SEXTANT_MCU_FAULTS_CYCLE_TIME_MS,        SEXTANT_MCU_REAL_TIME_CYCLE_TIME_MS,
    SEXTANT_MCU_TEMPERATURES_CYCLE_TIME_MS};

constexpr std::array<std::uint32_t, status_message_count> identifiers{
    SEXTANT_MCU_TORQUE_STATUS_FRAME_ID, SEXTANT_MCU_MOTION_FRAME_ID, SEXTANT_MCU_ELECTRICAL_FRAME_ID,
    SEXTANT_MCU_CAPABILITY_FRAME_ID,    SEXTANT_MCU_FAULTS_FRAME_ID, SEXTANT_MCU_REAL_TIME_FRAME_ID,
    SEXTANT_MCU_TEMPERATURES_FRAME_ID};

TorqueStatus torque_status_of(const Telemetry<double>& x) noexcept {
  TorqueStatus status{.torque = x.torque,
                      .torque_admitted = x.torque_reference,
                      .state = x.state,
                      .lockout = x.lockout,
                      .command_counter = {}};
  if (x.command_sequence != 0) status.command_counter = x.command_counter;
  return status;
}

FaultReport fault_report_of(const Telemetry<double>& x) noexcept {
  FaultReport report{.active = x.active, .latched = x.latched, .first = {}, .total = x.fault_total};
  if (x.latched.any()) report.first = x.first_fault;
  return report;
}

/// Messages that hold nothing but what was measured or estimated.
bool is_measurement(StatusMessage message) noexcept {
  return message == StatusMessage::motion || message == StatusMessage::electrical;
}

bool same(const FaultReport& a, const FaultReport& b) noexcept {
  return a.active == b.active && a.latched == b.latched && a.first == b.first && a.total == b.total;
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
      return encode(Capability{x.torque_motoring, x.torque_regenerating, extras.derating_cause});
    case StatusMessage::faults:
      return encode(fault_report_of(x));
    case StatusMessage::real_time:
      return encode(extras.real_time);
    case StatusMessage::temperatures:
      break;
  }
  return encode(extras.temperatures);
}

}  // namespace

std::int64_t cycle_time_ns(StatusMessage message) noexcept {
  return std::int64_t{cycle_times_ms[std::size_t(message)]} * 1'000'000;
}

bool is_status_frame(const CanFrame& frame) noexcept {
  if (frame.error || frame.extended) return false;
  return std::ranges::find(identifiers, frame.id) != identifiers.end();
}

StatusEncoder::StatusEncoder() noexcept
    : torque_status_(contract::mcu_torque_status_data_id),
      motion_(contract::mcu_motion_data_id),
      capability_(contract::mcu_capability_data_id) {}

CanFrame StatusEncoder::frame(StatusMessage message, const Telemetry<double>& drive,
                              const StatusExtras& extras) noexcept {
  EncodedFrame encoded = encode_message(message, drive, extras);
  if (encoded.clamped) ++clamped_;
  protect(message, encoded.frame);
  return encoded.frame;
}

std::span<const CanFrame> StatusEncoder::due(std::int64_t now_ns, const Telemetry<double>& drive,
                                             const StatusExtras& extras) noexcept {
  if (!started_) next_ns_.fill(now_ns);
  started_ = true;
  const FaultReport faults = fault_report_of(drive);
  std::size_t n = 0;
  for (std::size_t i = 0; i < status_message_count; ++i) {
    const auto message = static_cast<StatusMessage>(i);
    if (!is_due(i, now_ns, faults) || (is_measurement(message) && !extras.measured)) continue;
    frames_[n++] = frame(message, drive, extras);
  }
  sent_faults_ = faults;
  return {frames_.data(), n};
}

bool StatusEncoder::is_due(std::size_t message, std::int64_t now_ns, const FaultReport& faults) noexcept {
  const auto kind = static_cast<StatusMessage>(message);
  if (now_ns >= next_ns_[message]) {
    const std::int64_t cycle = cycle_time_ns(kind);
    next_ns_[message] += ((now_ns - next_ns_[message]) / cycle + 1) * cycle;
    return true;
  }
  return kind == StatusMessage::faults && !same(faults, sent_faults_);
}

std::int64_t StatusEncoder::next_due_ns() const noexcept {
  return *std::ranges::min_element(next_ns_);
}

void StatusEncoder::protect(StatusMessage message, CanFrame& frame) noexcept {
  E2eProtector* const protector = message == StatusMessage::torque_status ? &torque_status_
                                  : message == StatusMessage::motion      ? &motion_
                                  : message == StatusMessage::capability  ? &capability_
                                                                          : nullptr;
  if (protector == nullptr) return;
  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  protector->protect(data);
  std::ranges::copy(data, frame.data.begin());
}

}  // namespace sextant
