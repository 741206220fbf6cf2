#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <netinet/in.h>

#include "can_bus_counters.hpp"
#include "sextant/comms/can_bus.hpp"
#include "socket.hpp"

namespace sextant {

/// A CAN bus on a UDP multicast group, as python-can's interface `udp_multicast`. It sends from a socket of
/// its own, so that the sender's address identifies its own frames, which the kernel loops back. Both sockets
/// use the interface of the route at the opening.
class UdpMulticastBus final : public CanBus {
 public:
  /// Without `wanted` identifiers every frame is.
  UdpMulticastBus(const std::string& group, std::uint16_t port, std::span<const CanIdentifier> wanted = {});

  [[nodiscard]] CanSend send(const CanFrame& frame) noexcept override;
  [[nodiscard]] CanReceive receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept override;
  [[nodiscard]] CanBusStats stats() const noexcept override { return counters_.stats(); }
  [[nodiscard]] std::string trouble() const override;

 private:
  /// Result of one read of the socket: that of `receive`, or that more frames wait.
  struct Look {
    CanReceive result{CanReceive::timeout};
    bool more{false};
  };

  void open_sender(const sockaddr_in& group);
  void open_receiver(const sockaddr_in& group);
  [[nodiscard]] bool is_own(const sockaddr_storage& sender) const noexcept;
  [[nodiscard]] bool is_wanted(const CanFrame& frame) const noexcept;
  [[nodiscard]] Look read(CanFrame& frame) noexcept;
  [[nodiscard]] bool take(const Reception& reception, std::span<const std::byte> buffer,
                          CanFrame& frame) noexcept;

  std::string name_;
  std::vector<CanIdentifier> wanted_;
  int interface_{0};  // index; 0: by the routes
  Socket sending_;
  Socket receiving_;
  sockaddr_in own_{};
  Receiver receiver_;
  CanBusCounters counters_;
  std::atomic<bool> received_own_frame_{false};
};

}  // namespace sextant
