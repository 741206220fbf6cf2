#pragma once

#include <cstdint>
#include <string>

#include <netinet/in.h>

#include "can_bus_counters.hpp"
#include "sextant/comms/can_bus.hpp"
#include "socket.hpp"

namespace sextant {

/// A CAN bus on a UDP multicast group, as python-can's interface `udp_multicast` speaks it. It sends from a
/// socket of its own, so that its own frames, which the kernel loops back, are told apart by their sender.
class UdpMulticastBus final : public CanBus {
 public:
  UdpMulticastBus(const std::string& group, std::uint16_t port);

  [[nodiscard]] CanSend send(const CanFrame& frame) noexcept override;
  [[nodiscard]] CanReceive receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept override;
  [[nodiscard]] CanBusStats stats() const noexcept override { return counters_.stats(); }

 private:
  void open_sender(const sockaddr_in& group);
  void open_receiver(const sockaddr_in& group);
  [[nodiscard]] bool is_own(const sockaddr_storage& sender) const noexcept;
  [[nodiscard]] CanReceive read(CanFrame& frame) noexcept;

  std::string name_;
  Socket sending_;
  Socket receiving_;
  sockaddr_in own_{};
  Receiver receiver_;
  CanBusCounters counters_;
};

}  // namespace sextant
