#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/leg_tie.hpp"

namespace sextant {

/// Gate segments of which legs may be off, as switches and diodes tie the legs while no phase current changes
/// its sign: an off leg is low while its current is positive and high while it is negative. So the stator
/// voltage over all of them is known before they are integrated, as where every leg is driven
/// (`PlantIntegrator::advance_tied`), and whether the currents have kept their signs is seen afterwards.
///
/// Between both ends of a segment of t [s] a current departs from its chord by at most
///   t²/8 |d²i/dt²|,   |d²i/dt²| ≤ λ (λ (|psi_s| + |psi_r|) + |u_s|) di_s/dpsi_s
///   |u_s| ≤ 2/3 (u_dc + 2 V_t)
/// with λ of `DrivePlant::electrical_rate`; a current has kept its sign where it is beyond zero by more than
/// this at both ends. Without a threshold voltage only the currents of legs that are off count.
template <class Plant>
class TiedSegments {
 public:
  using T = typename Plant::Scalar;
  using State = typename Plant::State;

  /// By the signs of the currents at the plant's present state. acted: GatePattern::capacity at most; they
  /// must outlive this object.
  TiedSegments(const Plant& plant, std::span<const GateSegment> acted) noexcept SEXTANT_NONBLOCKING
      : plant_{plant},
        acted_{acted},
        at_begin_{phases_of(plant.i_s())},
        has_threshold_{plant.drops().threshold_voltage > T(0)} {
    for (std::size_t x = 0; x < 3; ++x) signs_[x] = at_begin_[x] < T(0) ? T(-1) : T(1);
    for (std::size_t k = 0; k < acted.size(); ++k) tied_[k] = {tied(acted[k].state), acted[k].duration_ns};
    const auto inverse = plant.machine().inverse_inductance(plant.psi_s(), plant.psi_r());
    const T rate = plant.electrical_rate();
    const T voltage = T(2) / T(3) * (plant.u_dc() + T(2) * plant.drops().threshold_voltage);
    bend_ = rate * (rate * (magnitude(plant.psi_s()) + magnitude(plant.psi_r())) + voltage) *
            (inverse.across + inverse.added_along) / T(8);
  }

  /// The same segments with every leg driven.
  [[nodiscard]] std::span<const GateSegment> segments() const noexcept SEXTANT_NONBLOCKING {
    return {tied_.data(), acted_.size()};
  }

  /// True where every current has kept its sign. corners: the state at the end of each segment.
  [[nodiscard]] bool hold(std::span<const State> corners) const noexcept SEXTANT_NONBLOCKING {
    std::array<T, 3> begin = at_begin_;
    for (std::size_t k = 0; k < acted_.size(); ++k) {
      const std::array<T, 3> end = phases_of(plant_.stator_current(corners[k]));
      const std::array<LegState, 3> legs = leg_states(acted_[k].state);
      const T t = T(1e-9) * T(acted_[k].duration_ns);
      for (std::size_t x = 0; x < 3; ++x) {
        if (!has_threshold_ && legs[x] != LegState::off) continue;
        if (!(std::min(signs_[x] * begin[x], signs_[x] * end[x]) > bend_ * t * t + least)) return false;
      }
      begin = end;
    }
    return true;
  }

 private:
  /// More than any tolerance for a current that counts as zero. [A]
  static constexpr T least = T(1e-3);

  [[nodiscard]] SwitchState tied(SwitchState acted) const noexcept SEXTANT_NONBLOCKING {
    std::array<LegState, 3> legs = leg_states(acted);
    for (std::size_t x = 0; x < 3; ++x) {
      if (legs[x] == LegState::off) legs[x] = signs_[x] < T(0) ? LegState::high : LegState::low;
    }
    return {legs[0], legs[1], legs[2]};
  }

  const Plant& plant_;
  std::span<const GateSegment> acted_;
  std::array<GateSegment, GatePattern::capacity> tied_{};
  std::array<T, 3> at_begin_;  ///< phase currents [A]
  std::array<T, 3> signs_{};   ///< their signs [-]
  bool has_threshold_;
  T bend_{};  ///< of a current from its chord, by the square of the time [A/s²]
};

}  // namespace sextant
