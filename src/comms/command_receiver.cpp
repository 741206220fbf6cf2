#include "sextant/comms/command_receiver.hpp"

#include <algorithm>

#include "sextant/comms/can_codec.hpp"

namespace sextant {
namespace {

FrameVerdict verdict_of(CommandIdentity identity) noexcept {
  switch (identity) {
    case CommandIdentity::command:
      return FrameVerdict::accepted;
    case CommandIdentity::other:
      return FrameVerdict::unrelated;
    case CommandIdentity::wrong_length:
      return FrameVerdict::wrong_length;
    case CommandIdentity::remote:
      return FrameVerdict::remote_frame;
    case CommandIdentity::extended_alias:
      return FrameVerdict::extended_alias;
    case CommandIdentity::fd_alias:
      return FrameVerdict::fd_alias;
  }
  return FrameVerdict::unrelated;
}

FrameVerdict verdict_of(E2eResult result) noexcept {
  switch (result) {
    case E2eResult::ok:
    case E2eResult::ok_some_lost:
      return FrameVerdict::accepted;
    case E2eResult::repeated:
      return FrameVerdict::repeated;
    case E2eResult::wrong_sequence:
      return FrameVerdict::wrong_sequence;
    case E2eResult::invalid_counter:
      return FrameVerdict::invalid_counter;
    case E2eResult::wrong_crc:
      return FrameVerdict::wrong_crc;
    case E2eResult::wrong_data_id:
      return FrameVerdict::wrong_data_id;
  }
  return FrameVerdict::wrong_crc;
}

}  // namespace

const char* to_string(FrameVerdict v) noexcept {
  switch (v) {
    case FrameVerdict::accepted:
      return "accepted";
    case FrameVerdict::unrelated:
      return "unrelated";
    case FrameVerdict::error_frame:
      return "error frame";
    case FrameVerdict::other_drive:
      return "another drive";
    case FrameVerdict::not_valid_yet:
      return "E2E state not valid yet";
    case FrameVerdict::wrong_length:
      return "wrong length";
    case FrameVerdict::remote_frame:
      return "remote frame";
    case FrameVerdict::extended_alias:
      return "extended identifier";
    case FrameVerdict::fd_alias:
      return "CAN FD frame";
    case FrameVerdict::wrong_crc:
      return "wrong CRC";
    case FrameVerdict::wrong_data_id:
      return "wrong data id";
    case FrameVerdict::invalid_counter:
      return "invalid counter";
    case FrameVerdict::repeated:
      return "repeated counter";
    case FrameVerdict::wrong_sequence:
      return "wrong sequence";
    case FrameVerdict::out_of_range:
      return "out of range";
  }
  return "?";
}

CommandReceiver::CommandReceiver(const Parameters& parameters) noexcept
    : parameters_(parameters),
      checker_(command_data_id(parameters.identifier_offset), parameters.e2e),
      other_drive_(parameters.identifier_offset),
      second_sender_(parameters.second_sender) {}

FrameVerdict CommandReceiver::on_frame(const CanFrame& frame) noexcept {
  const FrameVerdict verdict = evaluate(frame);
  ++counts_[std::size_t(verdict)];
  if (is_rejection(verdict)) command_.rejected = static_cast<std::uint32_t>(++rejected_);
  return verdict;
}

FrameVerdict CommandReceiver::evaluate(const CanFrame& frame) noexcept {
  if (frame.error) return on_error_frame(frame);
  if (other_drive_.sent(frame)) return FrameVerdict::other_drive;
  const FrameVerdict identity = verdict_of(identify_command(frame, parameters_.identifier_offset));
  if (identity != FrameVerdict::accepted) return identity;

  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  const E2eResult result = checker_.check(data);
  command_.e2e = checker_.state();
  command_.second_sender = second_sender_.add(data, result, frame.received_ns);
  if (!usable(result)) return verdict_of(result);
  return checker_.state() == E2eState::valid ? accept(frame) : FrameVerdict::not_valid_yet;
}

FrameVerdict CommandReceiver::accept(const CanFrame& frame) noexcept {
  const DecodedCommand decoded = decode_command(frame);
  if (!decoded.in_range && decoded.command.enable) {
    ++command_.out_of_range;
    return FrameVerdict::out_of_range;
  }
  store(decoded);
  command_.received_ns = frame.received_ns;
  command_.out_of_range = 0;
  ++command_.sequence;
  // An accepted command ends bus-off, unless it was received within the hold time after the report.
  if (frame.received_ns - bus_off_ns_ >= parameters_.bus_off_hold_ns) command_.bus_off = false;
  return FrameVerdict::accepted;
}

void CommandReceiver::store(const DecodedCommand& decoded) noexcept {
  const TorqueCommand<double>& received = decoded.command;
  // The numbers of a disable that lie beyond the contract, "not available" among them, stand as zero.
  command_.torque = decoded.in_range ? received.torque : 0.0;
  command_.torque_limit = decoded.in_range ? received.torque_limit : 0.0;
  command_.enable = received.enable;
  command_.fault_reset = received.fault_reset;
  command_.counter = received.counter;
  // A later command may replace this one before the control thread reads it: the counts keep it.
  if (!received.enable) ++command_.disables;
  if (!received.enable && received.fault_reset) ++command_.resets;
}

FrameVerdict CommandReceiver::on_error_frame(const CanFrame& frame) noexcept {
  if ((frame.id & can_error_bus_off) != 0) {
    command_.bus_off = true;
    bus_off_ns_ = frame.received_ns;
  }
  return FrameVerdict::error_frame;
}

}  // namespace sextant
