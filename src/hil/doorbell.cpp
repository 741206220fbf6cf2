#include "sextant/hil/doorbell.hpp"

#include <climits>
#include <ctime>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "sextant/realtime/cpu_relax.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

/// About 20 us; none where the other side could not run meanwhile. The machine's processors count, not those
/// that this thread may use: the other side may be bound to another one.
int spins_worth_while() {
  return sysconf(_SC_NPROCESSORS_ONLN) > 1 ? 600 : 0;
}

}  // namespace

Doorbell::Doorbell(std::atomic<std::uint32_t>& bell, std::atomic<std::uint32_t>& asleep) noexcept
    : bell_{bell}, asleep_{asleep}, spins_{spins_worth_while()} {}

// Waiting for the other side is what lockstep is; the drive runs in virtual time, so that nothing is late.
SEXTANT_TRUSTED_BEGIN

void Doorbell::ring() noexcept SEXTANT_NONBLOCKING {
  bell_.fetch_add(1, std::memory_order_seq_cst);
  if (asleep_.load(std::memory_order_seq_cst) == 0) return;
  syscall(SYS_futex, &bell_, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

bool Doorbell::wait(std::uint32_t seen, std::int64_t limit_ns) noexcept SEXTANT_NONBLOCKING {
  for (int n = 0; n < spins_; ++n) {
    if (value() != seen) return true;
    cpu_relax();
  }
  const std::int64_t end_ns = now_ns() + limit_ns;
  asleep_.store(1, std::memory_order_seq_cst);
  bool rung = false;
  while (!(rung = bell_.load(std::memory_order_seq_cst) != seen)) {
    const std::int64_t left_ns = end_ns - now_ns();
    if (left_ns <= 0) break;
    const timespec limit{static_cast<time_t>(left_ns / ns_per_s), static_cast<long>(left_ns % ns_per_s)};
    // Not a private futex: the other side is another process.
    syscall(SYS_futex, &bell_, FUTEX_WAIT, seen, &limit, nullptr, 0);
  }
  asleep_.store(0, std::memory_order_relaxed);
  return rung;
}

SEXTANT_TRUSTED_END

}  // namespace sextant
