#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// The plant at one end of a gate segment. Voltage and link current are those under the segment's own state.
template <class Plant>
struct PlantInstant {
  typename Plant::State x{};
  SpaceVector<> u_s{};  ///< stator voltage [V]
  double i_dc{};        ///< drawn from the DC link [A]
};

/// One gate segment that has been applied.
template <class Plant>
struct ActedSegment {
  SwitchState state{};
  std::int64_t duration_ns{};  ///< [ns]
  PlantInstant<Plant> begin{};
  PlantInstant<Plant> end{};
};

/// The plant over the last `read` of a power stage: every gate segment with the plant at
/// both of its ends, so that nothing that switched within a period is lost.
template <class Plant>
class SegmentLog {
 public:
  /// The segments of the last read, in order.
  [[nodiscard]] std::span<const ActedSegment<Plant>> segments() const noexcept SEXTANT_NONBLOCKING {
    return {segments_.data(), count_};
  }

  /// A read begins.
  void clear() noexcept SEXTANT_NONBLOCKING { count_ = 0; }

  /// A segment begins; the plant has its inputs.
  void begin(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    ActedSegment<Plant>& s = segments_[count_];
    s.state = plant.inputs().state;
    s.begin = instant(plant);
  }

  /// It has ended.
  void end(const Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING {
    segments_[count_].duration_ns = duration_ns;
    segments_[count_].end = instant(plant);
    ++count_;
  }

 private:
  static PlantInstant<Plant> instant(const Plant& plant) noexcept {
    return {plant.state(), plant.u_s(), plant.i_dc()};
  }

  // What was applied over one read is a pattern itself.
  std::array<ActedSegment<Plant>, GatePattern::capacity> segments_{};
  std::size_t count_{0};
};

/// The log that keeps nothing, for power stages whose plant is not observed.
template <class Plant>
class NoSegmentLog {
 public:
  void clear() noexcept SEXTANT_NONBLOCKING {}
  void begin(const Plant&) noexcept SEXTANT_NONBLOCKING {}
  void end(const Plant&, std::int64_t) noexcept SEXTANT_NONBLOCKING {}
};

}  // namespace sextant
