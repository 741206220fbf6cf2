#pragma once

#include <array>
#include <cstdint>

namespace sextant {

/// A value at which a comparator will switch, and the side it must be approached from.
template <class T = double>
struct Threshold {
  T level{};           ///< in the units of the compared error
  bool rising{false};  ///< true: crossed when the error exceeds the level; false: when it falls below

  /// True when `error` lies beyond the level. Equality is not a crossing: the output holds on the edge.
  [[nodiscard]] constexpr bool crossed_by(T error) const noexcept {
    return rising ? error > level : error < level;
  }
};

/// The thresholds in force in a comparator's present state: one or two of them.
template <class T = double>
struct Thresholds {
  std::array<Threshold<T>, 2> at{};
  std::uint8_t count{};
};

/// Sampled operation of a comparator: applies `on_crossing` until no threshold is crossed any more.
/// A three-level comparator that is overrun by the whole band within one sample crosses two of them.
template <class Comparator, class T>
constexpr void settle(Comparator& comparator, T error) noexcept {
  for (int passes = 0; passes < 2; ++passes) {
    const Thresholds<T> thresholds = comparator.thresholds();
    int crossed = -1;
    for (int i = 0; i < int(thresholds.count) && crossed < 0; ++i) {
      if (thresholds.at[unsigned(i)].crossed_by(error)) crossed = i;
    }
    if (crossed < 0) return;
    comparator.on_crossing(crossed);
  }
}

}  // namespace sextant
