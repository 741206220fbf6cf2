#pragma once

/// Marks a function that neither allocates, locks, throws nor blocks, nor calls one that does.
/// Clang's -Wfunction-effects checks it below every marked function; GCC sees nothing.
/// Usage: `void step() noexcept SEXTANT_NONBLOCKING;`
#if defined(__clang__) && __has_cpp_attribute(clang::nonblocking)
#define SEXTANT_NONBLOCKING [[clang::nonblocking]]
#else
#define SEXTANT_NONBLOCKING
#endif

/// The one suppression: the code between is trusted, because it calls a library without annotations (CVODE),
/// whose freedom from allocation is tested at run time, or because it makes system calls (sockets, lockstep).
/// docs/realtime.md lists the places.
#if defined(__clang__) && __has_cpp_attribute(clang::nonblocking)
#define SEXTANT_TRUSTED_BEGIN \
  _Pragma("clang diagnostic push") _Pragma("clang diagnostic ignored \"-Wfunction-effects\"")
#define SEXTANT_TRUSTED_END _Pragma("clang diagnostic pop")
#else
#define SEXTANT_TRUSTED_BEGIN
#define SEXTANT_TRUSTED_END
#endif
