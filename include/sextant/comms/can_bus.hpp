#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "sextant/comms/can_frame.hpp"

namespace sextant {

enum class CanSend : std::uint8_t {
  ok,
  no_buffer,  ///< the queue of the interface is full: the frame was dropped and counted
  down,       ///< the interface is down or gone
  error       ///< anything else
};

enum class CanReceive : std::uint8_t {
  got,      ///< a frame, which may be an error frame
  timeout,  ///< no frame within the timeout
  down,     ///< the interface is down or gone; `receive` reopens the bus when the interface is back
  error     ///< anything else; the cause was counted
};

/// Counts since the bus was opened.
struct CanBusStats {
  std::uint64_t sent{};               ///< frames handed to the interface [-]
  std::uint64_t send_dropped{};       ///< frames that `send` could not hand over [-]
  std::uint64_t received{};           ///< frames handed to the caller [-]
  std::uint64_t receive_overflow{};   ///< frames dropped because the socket's queue was full [-]
  std::uint64_t receive_malformed{};  ///< datagrams that are no CAN frame [-]
  std::uint64_t error_frames{};       ///< reports of the interface [-]
  std::uint64_t bus_off{};            ///< reports of bus-off [-]
  std::uint64_t reopened{};           ///< times the bus was reopened [-]
};

/// The seam to a CAN bus. One thread may receive while another sends; neither call throws, and `send` never
/// blocks. Frames that this object sent are not received by it.
class CanBus {
 public:
  CanBus() = default;
  CanBus(const CanBus&) = delete;
  CanBus& operator=(const CanBus&) = delete;
  virtual ~CanBus() = default;

  [[nodiscard]] virtual CanSend send(const CanFrame& frame) noexcept = 0;

  /// Waits for a frame for at most `timeout`; with zero it polls.
  [[nodiscard]] virtual CanReceive receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept = 0;

  [[nodiscard]] virtual CanBusStats stats() const noexcept = 0;

  /// A problem of the bus as a whole, in one sentence; empty while none is detected.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
};

/// Opens the bus at an address, `socketcan:<interface>` or `udp_multicast:<IPv4 group>:<port>`. The bus
/// receives the `wanted` identifiers and error frames; without `wanted` every frame. Other frames are not
/// counted; of a CAN interface the kernel filters them. Throws std::runtime_error with one sentence: what is
/// wrong and what to do.
[[nodiscard]] std::unique_ptr<CanBus> make_can_bus(std::string_view address,
                                                   std::span<const CanIdentifier> wanted = {});

}  // namespace sextant
