#pragma once

#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Moves a plant through time. The seam between the fixed-step integrator and CVODE.
template <class Plant>
class PlantIntegrator {
 public:
  PlantIntegrator() = default;
  PlantIntegrator(const PlantIntegrator&) = delete;
  PlantIntegrator& operator=(const PlantIntegrator&) = delete;
  virtual ~PlantIntegrator() = default;

  /// Integrates over duration_ns [ns] with the plant's inputs held, through the diode events on the way. A
  /// duration of zero or less does nothing. False when the integration failed; the plant is then as it was
  /// before the call, and the caller must report it.
  [[nodiscard]] virtual bool advance(Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING = 0;

  /// Clears the history of the solution; to be called before another plant is advanced.
  virtual void reset() noexcept SEXTANT_NONBLOCKING = 0;
};

}  // namespace sextant
