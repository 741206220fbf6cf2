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
                              bool enable = true) {
  CanFrame frame = encode(TorqueRequest{.torque = torque, .torque_limit = 100.0, .enable = enable}).frame;
  protect(frame, command_data_id(), counter);
  frame.received_ns = received_ns;
  return frame;
}

}  // namespace sextant::testing
