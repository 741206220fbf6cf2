#pragma once

#include <array>
#include <cstdint>

namespace sextant {

/// One frame of the bus, classic CAN or CAN FD.
struct CanFrame {
  std::uint32_t id{};                   ///< 11 or 29 bits; the error class (linux/can/error.h) if `error`
  bool extended{false};                 ///< 29-bit identifier
  bool rtr{false};                      ///< remote transmission request
  bool error{false};                    ///< a report of the interface, no frame of the bus
  bool fd{false};                       ///< CAN FD
  std::uint8_t length{};                ///< valid bytes of `data`, up to 8, or up to 64 if `fd` [bytes]
  std::array<std::uint8_t, 64> data{};  ///< zero beyond `length`
  std::int64_t received_ns{};           ///< arrival on CLOCK_MONOTONIC; 0 for a frame to send [ns]
};

/// An identifier of the bus.
struct CanIdentifier {
  std::uint32_t id{};    ///< 11 or 29 bits
  bool extended{false};  ///< 29-bit identifier

  friend constexpr bool operator==(CanIdentifier, CanIdentifier) noexcept = default;
};

/// Bit of `CanFrame::id` in an error frame: the controller has left the bus.
inline constexpr std::uint32_t can_error_bus_off = 0x40;

}  // namespace sextant
