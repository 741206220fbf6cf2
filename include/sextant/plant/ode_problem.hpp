#pragma once

#include <cstdint>

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
};

/// Where a solver stopped: at the end of the segment, at an event before it, or nowhere of use.
enum class SolverOutcome : std::uint8_t { reached, event, failed };

}  // namespace sextant
