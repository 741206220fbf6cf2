#pragma once

#include <cstdint>

#include "sextant/comms/can_frame.hpp"
#include "sextant/virtual_time/virtual_clock.hpp"

namespace sextant {

/// What a virtual bus does to the frames on their way to the drive, or to the drive's interface.
enum class BusEventKind : std::uint8_t {
  lose,       ///< the frame never arrives
  corrupt,    ///< one byte arrives changed, as by a gateway with a fault: a CAN controller drops line errors
  delay,      ///< the frame arrives later; those behind it do not wait
  duplicate,  ///< the frame arrives twice
  reorder,    ///< the frame arrives after the next one
  burst,      ///< the frames of the window arrive together at its end
  insert,     ///< a frame of another node
  bus_off,    ///< the controller leaves the bus: an error frame, then no frame in either direction until the
              ///< end
  interface_down,  ///< the interface is down until the end; what was on the way is lost
  refuse_transmit  ///< the transmit queue is full until the end
};

inline constexpr int bus_event_kinds = 10;

[[nodiscard]] constexpr const char* to_string(BusEventKind kind) noexcept {
  switch (kind) {
    case BusEventKind::lose:
      return "lose";
    case BusEventKind::corrupt:
      return "corrupt";
    case BusEventKind::delay:
      return "delay";
    case BusEventKind::duplicate:
      return "duplicate";
    case BusEventKind::reorder:
      return "reorder";
    case BusEventKind::burst:
      return "burst";
    case BusEventKind::insert:
      return "insert";
    case BusEventKind::bus_off:
      return "bus-off";
    case BusEventKind::interface_down:
      return "interface down";
    case BusEventKind::refuse_transmit:
      return "refuse transmit";
  }
  return "?";
}

/// Something that happens on the bus at a virtual time. The first six kinds affect the frames that are put on
/// the bus in [begin, end), on `count` of them at most.
struct BusEvent {
  BusEventKind kind{BusEventKind::lose};
  std::int64_t begin_ns{0};       ///< [ns]
  std::int64_t end_ns{never_ns};  ///< not used by `insert` [ns]
  std::uint32_t count{0};         ///< frames affected; 0: all in the window [-]
  std::int64_t delay_ns{0};       ///< of `delay`, and until the second frame of `duplicate` [ns]
  std::uint8_t byte{0};           ///< of the frame, for `corrupt` [-]
  std::uint8_t mask{0xFF};        ///< XORed into that byte [-]
  CanFrame frame{};               ///< of `insert`

  [[nodiscard]] constexpr const char* validate() const noexcept {
    if (kind != BusEventKind::insert && end_ns <= begin_ns) return "a bus event must end after its beginning";
    if (delay_ns < 0) return "a bus cannot deliver a frame before it was sent";
    if (kind == BusEventKind::burst && end_ns == never_ns) return "a burst needs an end";
    if (kind == BusEventKind::corrupt && (mask == 0 || byte >= frame.data.size())) {
      return "a corruption must change a bit of a byte from 0 to 63";
    }
    return nullptr;
  }
};

}  // namespace sextant
