#pragma once

#include <span>
#include <string>
#include <vector>

#include <linux/can.h>

#include "can_bus_counters.hpp"
#include "sextant/comms/can_bus.hpp"
#include "socket.hpp"

namespace sextant {

/// A CAN interface of Linux (CAN_RAW): can0, vcan0. Error frames and CAN FD frames are received too, so that
/// they are counted as rejected. When the interface goes down or away, the receiving thread binds
/// the socket again as soon as it is back. The kernel filters all other frames.
class SocketCanBus final : public CanBus {
 public:
  /// Without `wanted` identifiers every frame is.
  explicit SocketCanBus(const std::string& interface, std::span<const CanIdentifier> wanted = {});

  [[nodiscard]] CanSend send(const CanFrame& frame) noexcept override;
  [[nodiscard]] CanReceive receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept override;
  [[nodiscard]] CanBusStats stats() const noexcept override { return counters_.stats(); }

 private:
  void configure() const;
  [[nodiscard]] bool bind_interface() const noexcept;
  [[nodiscard]] bool is_up() const noexcept;
  void try_to_reopen() noexcept;
  [[nodiscard]] CanReceive on_receive_error(int error) noexcept;

  std::string interface_;
  std::vector<can_filter> filters_;
  Socket socket_;
  Receiver receiver_;
  CanBusCounters counters_;
  bool down_{false};  // of the receiving thread
};

}  // namespace sextant
