#pragma once

#include <cstdint>

namespace sextant::audit {

/// POSIX locks that the calling thread has taken or waited for since it started: mutexes, read-write locks,
/// spin locks, condition variables and semaphores. The program's own functions of these names stand before
/// the C library's. [-]
[[nodiscard]] std::uint64_t locks() noexcept;

}  // namespace sextant::audit
