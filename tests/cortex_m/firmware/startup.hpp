#pragma once

#include <cstddef>

/// The program; called once everything is in place.
[[noreturn]] void run_firmware();

/// The most that the stack has held since reset: the memory below was painted before. [B]
[[nodiscard]] std::size_t stack_used();
