#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/plant/acted_segments.hpp"

namespace sextant {

/// A gate segment that has been applied.
struct ActedSegment {
  SwitchState state{};
  std::int64_t duration_ns{};  ///< [ns]
  SpaceVector<> u_s_begin{};   ///< stator voltage at its beginning; it changes within while a leg is off [V]
  SpaceVector<> u_s_end{};     ///< at its end [V]
  std::size_t begin{};         ///< of `SegmentLog::instants`
  std::size_t end{};           ///< the same
};

/// The plant over the last `read` of a power stage: every gate segment with the plant's states at both of its
/// ends, so that nothing that switched within a period is lost. Segments that follow each other share the
/// state between them, unless it has jumped there.
template <class Plant>
class SegmentLog {
 public:
  using State = typename Plant::State;
  static constexpr bool wants_corners = true;

  /// The segments of the last read, in order.
  [[nodiscard]] std::span<const ActedSegment> segments() const noexcept SEXTANT_NONBLOCKING {
    return {segments_.data(), count_};
  }
  /// The states at their ends, in order.
  [[nodiscard]] std::span<const State> instants() const noexcept SEXTANT_NONBLOCKING {
    return {instants_.data(), instant_count_};
  }

  /// A read begins.
  void clear() noexcept SEXTANT_NONBLOCKING { count_ = instant_count_ = 0; }

  /// The plant is about to advance; it has its inputs.
  void begin(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    u_s_begin_ = plant.u_s();
    if (instant_count_ == 0 || instants_[instant_count_ - 1] != plant.state())
      instants_[instant_count_++] = plant.state();
  }

  /// It has advanced over one segment, or over several whose legs are all driven; corners: the state at the
  /// end of each.
  void end(const Plant& plant, std::span<const GateSegment> segments, std::span<const State> corners,
           bool resumes) noexcept SEXTANT_NONBLOCKING {
    end(plant, segments, segments, {}, corners, resumes);
  }

  /// The same over segments whose legs are tied as those of `tied` are driven (`TiedSegments`), with the
  /// voltage that thresholds take. [V]
  void end(const Plant& plant, std::span<const GateSegment> segments, std::span<const GateSegment> tied,
           SpaceVector<> lost, std::span<const State> corners, bool resumes) noexcept SEXTANT_NONBLOCKING {
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const auto& [state, duration_ns] = segments[k];
      const bool driven = segments.size() > 1;
      const SpaceVector<> fixed =
          driven ? stator_voltage(tied[k].state, plant.inputs().u_dc) - lost : u_s_begin_;
      add({state, duration_ns, fixed, driven ? fixed : plant.u_s(), instant_count_ - 1, instant_count_},
          corners[k], resumes && k == 0);
    }
  }

 private:
  static constexpr std::size_t capacity = ActedSegments::capacity;

  void add(const ActedSegment& segment, const State& end, bool resumes) noexcept SEXTANT_NONBLOCKING {
    if (resumes && count_ > 0) {
      ActedSegment& last = segments_[count_ - 1];
      last.duration_ns += segment.duration_ns;
      last.u_s_end = segment.u_s_end;
      // A state that has jumped at the stop is not kept.
      instants_[last.end] = end;
      instant_count_ = last.end + 1;
      return;
    }
    segments_[count_++] = segment;
    instants_[instant_count_++] = end;
  }

  std::array<ActedSegment, capacity> segments_{};
  std::size_t count_{0};
  std::array<State, 2 * capacity> instants_{};
  std::size_t instant_count_{0};
  SpaceVector<> u_s_begin_{};  ///< [V]
};

/// The log that keeps nothing, for power stages whose plant is not observed.
template <class Plant>
class NoSegmentLog {
 public:
  static constexpr bool wants_corners = false;
  void clear() noexcept SEXTANT_NONBLOCKING {}
  void begin(const Plant&) noexcept SEXTANT_NONBLOCKING {}
  void end(const Plant&, std::span<const GateSegment>, std::span<const typename Plant::State>,
           bool) noexcept SEXTANT_NONBLOCKING {}
  void end(const Plant&, std::span<const GateSegment>, std::span<const GateSegment>, SpaceVector<>,
           std::span<const typename Plant::State>, bool) noexcept SEXTANT_NONBLOCKING {}
};

}  // namespace sextant
