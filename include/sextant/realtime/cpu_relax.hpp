#pragma once

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Marks a waiting loop for the processor, which then leaves the core's other hardware thread and
/// its power alone. Nothing where the architecture has no such instruction.
inline void cpu_relax() noexcept SEXTANT_NONBLOCKING {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#elif defined(__aarch64__) || defined(__arm__)
  asm volatile("yield");
#endif
}

}  // namespace sextant
