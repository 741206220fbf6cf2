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
  timeout,  ///< nothing came
  down,     ///< the interface is down or gone; the bus comes back by itself when the interface does
  error     ///< anything else; the cause was counted
};

/// What happened since the bus was opened.
struct CanBusStats {
  std::uint64_t sent{};               ///< frames handed to the interface [-]
  std::uint64_t send_dropped{};       ///< frames that `send` could not hand over [-]
  std::uint64_t received{};           ///< frames handed to the caller [-]
  std::uint64_t receive_overflow{};   ///< frames that the socket dropped because nobody read them [-]
  std::uint64_t receive_malformed{};  ///< datagrams that are no CAN frame [-]
  std::uint64_t error_frames{};       ///< reports of the interface [-]
  std::uint64_t bus_off{};            ///< those that said bus-off [-]
  std::uint64_t reopened{};           ///< times that the interface came back [-]
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

  /// Waits for a frame for at most `timeout`; zero looks only at what has arrived.
  [[nodiscard]] virtual CanReceive receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept = 0;

  [[nodiscard]] virtual CanBusStats stats() const noexcept = 0;

  /// What is wrong with the bus as a whole for all that can be seen from here, in one sentence; empty where
  /// nothing is.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
};

/// Opens the bus at an address, `socketcan:<interface>` or `udp_multicast:<IPv4 group>:<port>`. Frames of
/// other than the `wanted` identifiers are never received and counted nowhere, of a CAN interface not even by
/// this process; with none given every frame is. Error frames always are. Throws std::runtime_error with one
/// sentence that says what is wrong and what to do.
[[nodiscard]] std::unique_ptr<CanBus> make_can_bus(std::string_view address,
                                                   std::span<const CanIdentifier> wanted = {});

}  // namespace sextant
