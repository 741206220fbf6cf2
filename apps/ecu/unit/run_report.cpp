#include "ecu/unit/run_report.hpp"

#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "sextant/comms/can_codec.hpp"

namespace sextant::ecu {

void print_commands(std::FILE* out, const CommandReceiver& receiver, IdentifierOffset offset) {
  const std::uint64_t accepted = receiver.count(FrameVerdict::accepted);
  fmt::print(out, "commands {} accepted, {} rejected\n", accepted, receiver.rejected());
  if (accepted + receiver.rejected() == 0) {
    fmt::print(out, "  no frame has the command's identifier 0x{:03X} (can.identifier_offset = {})\n",
               command_id(offset), offset.value);
  }
  for (std::size_t i = 0; i < frame_verdict_count; ++i) {
    const auto verdict = static_cast<FrameVerdict>(i);
    const std::uint64_t count = receiver.count(verdict);
    if (is_rejection(verdict) && count > 0) fmt::print(out, "  {:<23} {}\n", to_string(verdict), count);
  }
}

std::string tripped_text(Fault first, const std::string& source) {
  const std::string text = fmt::format("the drive went to FAULT ({})", to_string(first));
  return source.empty() ? text : text + " while it followed " + source;
}

void print_can(std::FILE* out, const CanBusStats& stats, std::uint64_t clamped) {
  fmt::print(out, "CAN {} sent, {} not sent, {} received\n", stats.sent, stats.send_dropped, stats.received);
  if (stats.receive_overflow + stats.receive_malformed > 0) {
    fmt::print(out, "  {} lost and {} unreadable on reception\n", stats.receive_overflow,
               stats.receive_malformed);
  }
  if (stats.error_frames + stats.reopened > 0) {
    fmt::print(out, "  {} error frames, {} of them bus-off; bus reopened {} times\n", stats.error_frames,
               stats.bus_off, stats.reopened);
  }
  if (clamped > 0) fmt::print(out, "  {} status frames held a value beyond its signal's range\n", clamped);
}

}  // namespace sextant::ecu
