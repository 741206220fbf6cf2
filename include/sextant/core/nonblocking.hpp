#pragma once

/// Marks a function that neither allocates, locks, throws nor blocks, nor calls one that does.
/// Clang's -Wfunction-effects checks it below every marked function; GCC sees nothing.
/// Usage: `void step() noexcept SEXTANT_NONBLOCKING;`
#if defined(__clang__) && __has_cpp_attribute(clang::nonblocking)
#define SEXTANT_NONBLOCKING [[clang::nonblocking]]
#else
#define SEXTANT_NONBLOCKING
#endif

/// The one listed suppression: a DriveIo or an integrator is trusted here, because what stands behind the
/// seam is the platform's own (a driver, CVODE) and is audited at run time instead.
#if defined(__clang__) && __has_cpp_attribute(clang::nonblocking)
#define SEXTANT_TRUSTED_BEGIN \
  _Pragma("clang diagnostic push") _Pragma("clang diagnostic ignored \"-Wfunction-effects\"")
#define SEXTANT_TRUSTED_END _Pragma("clang diagnostic pop")
#else
#define SEXTANT_TRUSTED_BEGIN
#define SEXTANT_TRUSTED_END
#endif
