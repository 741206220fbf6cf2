#pragma once

#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {

SEXTANT_TRUSTED_BEGIN
/// CLOCK_MONOTONIC, which the kernel lets a process read without a system call. [ns]
[[nodiscard]] inline std::int64_t clock_ns() noexcept SEXTANT_NONBLOCKING {
  return now_ns();
}
SEXTANT_TRUSTED_END

}  // namespace sextant
