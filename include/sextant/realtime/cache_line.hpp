#pragma once

#include <cstddef>

namespace sextant {

/// What two threads write is kept this far apart, so that neither takes the other's cache line away. A fixed
/// number, because std::hardware_destructive_interference_size changes with compiler flags and with it the
/// layout; 64 serves x86-64 and Cortex-A. [bytes]
inline constexpr std::size_t cache_line = 64;

}  // namespace sextant
