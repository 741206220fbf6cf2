#include "ecu/command_report.hpp"

#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

namespace sextant::ecu {

void print_commands(std::FILE* out, const CommandReceiver& receiver) {
  fmt::print(out, "commands {} accepted, {} rejected\n", receiver.count(FrameVerdict::accepted),
             receiver.rejected());
  for (std::size_t i = 0; i < frame_verdict_count; ++i) {
    const auto verdict = static_cast<FrameVerdict>(i);
    const std::uint64_t count = receiver.count(verdict);
    if (is_rejection(verdict) && count > 0) fmt::print(out, "  {:<23} {}\n", to_string(verdict), count);
  }
}

}  // namespace sextant::ecu
