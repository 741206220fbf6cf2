#pragma once

#include <algorithm>
#include <cstdint>

#include "sextant/comms/can_codec.hpp"
#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/e2e_profile11.hpp"

namespace sextant::testing {

/// Protects the first eight bytes of a frame.
inline void protect(CanFrame& frame, std::uint16_t data_id, std::uint8_t counter) {
  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  e2e::protect(data_id, counter, data);
  std::ranges::copy(data, frame.data.begin());
}

/// A command as the vehicle control unit sends it.
inline CanFrame command_frame(std::uint8_t counter, double torque, std::int64_t received_ns = 0,
                              bool enable = true, IdentifierOffset offset = {}) {
  CanFrame frame = encode(TorqueCommand<>{.torque = torque, .torque_limit = 100.0, .enable = enable}).frame;
  frame.id = command_id(offset);
  protect(frame, command_data_id(offset), counter);
  frame.received_ns = received_ns;
  return frame;
}

}  // namespace sextant::testing
