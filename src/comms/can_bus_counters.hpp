#pragma once

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>

#include "sextant/comms/can_bus.hpp"

namespace sextant {

/// CanBusStats for concurrent counting by the receiving and the sending thread.
class CanBusCounters {
 public:
  using Counter = std::atomic<std::uint64_t>;

  Counter sent{0};
  Counter send_dropped{0};
  Counter received{0};
  Counter receive_overflow{0};
  Counter receive_malformed{0};
  Counter error_frames{0};
  Counter bus_off{0};
  Counter reopened{0};

  /// Counts a send() that returned `n` for `size` bytes; errno with a negative `n`.
  CanSend on_sent(std::ptrdiff_t n, std::size_t size, bool (*means_down)(int)) noexcept {
    if (n == static_cast<std::ptrdiff_t>(size)) {
      sent.fetch_add(1, std::memory_order_relaxed);
      return CanSend::ok;
    }
    const int error = errno;
    send_dropped.fetch_add(1, std::memory_order_relaxed);
    if (n >= 0) return CanSend::error;  // errno belongs to failed calls only
    if (error == ENOBUFS || error == EAGAIN) return CanSend::no_buffer;
    return means_down(error) ? CanSend::down : CanSend::error;
  }

  void on_received(const CanFrame& frame) noexcept {
    received.fetch_add(1, std::memory_order_relaxed);
    if (!frame.error) return;
    error_frames.fetch_add(1, std::memory_order_relaxed);
    if ((frame.id & can_error_bus_off) != 0) bus_off.fetch_add(1, std::memory_order_relaxed);
  }

  /// SO_RXQ_OVFL reports the total since the socket was opened, modulo 2^32.
  void on_overflow_total(std::uint32_t total) noexcept {
    const std::uint32_t seen = static_cast<std::uint32_t>(receive_overflow.load(std::memory_order_relaxed));
    receive_overflow.fetch_add(total - seen, std::memory_order_relaxed);
  }

  [[nodiscard]] CanBusStats stats() const noexcept {
    return {.sent = sent.load(std::memory_order_relaxed),
            .send_dropped = send_dropped.load(std::memory_order_relaxed),
            .received = received.load(std::memory_order_relaxed),
            .receive_overflow = receive_overflow.load(std::memory_order_relaxed),
            .receive_malformed = receive_malformed.load(std::memory_order_relaxed),
            .error_frames = error_frames.load(std::memory_order_relaxed),
            .bus_off = bus_off.load(std::memory_order_relaxed),
            .reopened = reopened.load(std::memory_order_relaxed)};
  }
};

}  // namespace sextant
