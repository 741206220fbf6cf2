#pragma once

#include <atomic>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// How one process wakes another in lockstep: a counter in shared memory that one side increments. The other
/// spins on it for some microseconds, which a hand-over between two processors takes, and then sleeps in the
/// kernel (futex), so that it works on one processor too. Only for lockstep: it makes system calls.
class Doorbell {
 public:
  /// `bell` is rung by one side; `asleep` is 1 while the other sleeps on it.
  Doorbell(std::atomic<std::uint32_t>& bell, std::atomic<std::uint32_t>& asleep) noexcept;

  void ring() noexcept SEXTANT_NONBLOCKING;

  /// Waits until the bell's value differs from `seen`; false after `limit_ns`.
  [[nodiscard]] bool wait(std::uint32_t seen, std::int64_t limit_ns) noexcept SEXTANT_NONBLOCKING;

  [[nodiscard]] std::uint32_t value() const noexcept SEXTANT_NONBLOCKING {
    return bell_.load(std::memory_order_acquire);
  }

 private:
  std::atomic<std::uint32_t>& bell_;
  std::atomic<std::uint32_t>& asleep_;
  int spins_;
};

}  // namespace sextant
