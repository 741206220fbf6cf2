#pragma once

#include <cstdint>
#include <limits>

namespace sextant {

/// The equations that a variable-step solver integrates, as plain functions of a context.
struct OdeProblem {
  int size{};         ///< number of states [-]
  int event_count{};  ///< number of event functions; 0 runs without root finding [-]
  void (*derivative)(const void* context, const double* x, double* dx) noexcept {};
  /// ∂(dx/dt)/∂x, column-major; for implicit methods.
  void (*jacobian)(const void* context, const double* x, double* j) noexcept {};
  /// Event functions; an event is a fall through zero.
  void (*events)(const void* context, const double* x, double* g) noexcept {};
  /// The states from here on are integrals that nothing depends on and that grow without bound, as a meter's:
  /// the relative tolerance does not count for them, or their error would grow with them.
  int relative_states{std::numeric_limits<int>::max()};
};

/// Where a solver stopped: at the end of the segment, at an event before it, or nowhere of use.
enum class SolverOutcome : std::uint8_t { reached, event, failed };

}  // namespace sextant
