#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Datagrams to and from one peer. Neither call waits. They are system calls: a network cannot be had
/// without, and a drive that needs none on its control thread takes shared memory.
class UdpSocket {
 public:
  /// More datagrams than the kernel keeps for one socket: a caller that reads so many has emptied it, or is
  /// flooded.
  static constexpr int more_than_it_keeps = 4096;

  /// Addresses are "<IPv4 address>:<port>". Throws std::runtime_error with one sentence that names the key
  /// when one is malformed or cannot be had.
  UdpSocket(const std::string& listen, const std::string& peer);
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  ~UdpSocket();

  /// False when the kernel did not send it: no route, no buffer, or refused by the peer's machine.
  bool send(std::span<const std::byte> datagram) const noexcept SEXTANT_NONBLOCKING;

  /// Length of the next datagram, cut off at the buffer's; 0 when there is none. [bytes]
  [[nodiscard]] std::size_t receive(std::span<std::byte> buffer) const noexcept SEXTANT_NONBLOCKING;

 private:
  int file_;
};

/// A number for one start of a process, above zero: at random, so that no clock has to be right.
[[nodiscard]] std::uint32_t random_generation();

}  // namespace sextant
