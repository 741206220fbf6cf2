#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
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

  /// The same over gate segments that follow each other, GatePattern::capacity at most, the plant's other
  /// inputs held. corners: the state at the end of each segment, or empty where nobody asks for it. After a
  /// failure the plant is as it was before the segment that failed, or before all of them. Integrators that
  /// do not have to stop where the inverter switches have a faster way.
  [[nodiscard]] virtual bool advance_through(Plant& plant, std::span<const GateSegment> segments,
                                             std::span<typename Plant::State> corners) noexcept
      SEXTANT_NONBLOCKING {
    for (std::size_t k = 0; k < segments.size(); ++k) {
      plant.set_switch_state(segments[k].state);
      if (!advance(plant, segments[k].duration_ns)) return false;
      if (!corners.empty()) corners[k] = plant.state();
    }
    return true;
  }

  /// The same over segments of `TiedSegments`, every leg driven, while the currents keep the signs that they
  /// have: what a threshold voltage takes is constant. For integrators that say so (`ties`).
  [[nodiscard]] virtual bool advance_tied(Plant&, std::span<const GateSegment>,
                                          std::span<typename Plant::State>) noexcept SEXTANT_NONBLOCKING {
    return false;
  }
  /// True where the integrator goes over the switching of `TiedSegments`.
  [[nodiscard]] virtual bool ties() const noexcept SEXTANT_NONBLOCKING { return false; }

  /// Clears the history of the solution; to be called before another plant is advanced, and where the load
  /// torque or the slope of an imposed speed jumps.
  virtual void reset() noexcept SEXTANT_NONBLOCKING = 0;
};

}  // namespace sextant
