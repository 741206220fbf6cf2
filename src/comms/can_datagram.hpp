#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "sextant/comms/can_frame.hpp"

namespace sextant {

/// A CAN frame as python-can's interface `udp_multicast` puts it into a datagram: a MessagePack map of the
/// fields of `can.Message`.
struct CanDatagram {
  std::array<char, 320> bytes{};
  std::size_t length{};  ///< [bytes]
};

/// The frame as a datagram, stamped with `timestamp`, the wall clock. [s]
[[nodiscard]] CanDatagram pack_datagram(const CanFrame& frame, double timestamp) noexcept;

/// The frame of a datagram; nothing if it is none. Keys that are not known are ignored.
[[nodiscard]] std::optional<CanFrame> unpack_datagram(std::span<const char> bytes) noexcept;

}  // namespace sextant
