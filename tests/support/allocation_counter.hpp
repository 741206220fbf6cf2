#pragma once

#include <cstdint>

namespace sextant::testing {

/// Whether this program counts its heap allocations (not under a sanitizer, which has an allocator of its
/// own).
[[nodiscard]] bool allocations_are_counted() noexcept;

/// Heap allocations of the calling thread since it started, by malloc and everything on top of it. [-]
[[nodiscard]] std::uint64_t allocations() noexcept;

}  // namespace sextant::testing
