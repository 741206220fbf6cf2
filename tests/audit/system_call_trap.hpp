#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sextant::audit {

/// From now on every system call of the calling thread is caught and refused (ENOSYS), but for
/// clock_nanosleep where `may_sleep`, for the end of the thread and for the return from a signal handler. It
/// cannot be undone. A filter of the kernel (seccomp), so that nothing gets past it. Throws
/// std::runtime_error where the kernel refuses it.
void trap_system_calls(bool may_sleep);

/// From now on what is caught counts no longer.
void stop_counting_system_calls() noexcept;

/// Calls caught so far by all threads. [-]
[[nodiscard]] std::uint64_t trapped_system_calls() noexcept;

/// Names of the first sixteen of them.
[[nodiscard]] std::vector<std::string> trapped_names();

}  // namespace sextant::audit
