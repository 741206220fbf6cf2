#pragma once

#include <cstdint>

#include "sextant/control/towards.hpp"

namespace sextant {

/// A direct current that falls in equal steps through levels of both signs, from the highest to its opposite,
/// and ends at zero. Of n levels of a sign level m has
///   I_m = I (1 − 4/5 · m/(n − 1)),   m = 0 … n − 1
/// so that the lowest is a fifth of the highest. Each level is reached by a ramp, settles and is held. A
/// stair in one direction has the smallest steps: what of the rotor's EMF is left after settling is the same
/// at nearly every level, and shows as an offset of the voltage.
template <class T = double>
class CurrentStaircase {
 public:
  static constexpr T lowest_share = T(0.2);  ///< of the highest level [-]

  struct Parameters {
    T highest{T(1)};                 ///< I [A]
    int levels{4};                   ///< n, of each sign, 2 at least [-]
    T slope{T(0.1)};                 ///< of the ramps, by the period [A]
    std::int32_t settle_periods{1};  ///< [-]
    std::int32_t hold_periods{1};    ///< [-]
  };

  constexpr explicit CurrentStaircase(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// The current in the coming period. [A]
  constexpr T step() noexcept {
    if (is_done()) return reference_ = ramped(T(0));
    const T level = target(index_);
    if (reference_ != level) {
      elapsed_ = 0;
      return reference_ = ramped(level);
    }
    if (elapsed_ == parameters_.settle_periods + parameters_.hold_periods) {
      elapsed_ = 0;
      ++index_;
      return reference_ = ramped(is_done() ? T(0) : target(index_));
    }
    ++elapsed_;
    return reference_;
  }

  /// The coming period belongs to a level that has settled.
  [[nodiscard]] constexpr bool holds() const noexcept {
    return !is_done() && elapsed_ > parameters_.settle_periods;
  }
  /// It is the last one of a level.
  [[nodiscard]] constexpr bool ends_level() const noexcept {
    return holds() && elapsed_ == parameters_.settle_periods + parameters_.hold_periods;
  }
  /// Levels that are over. [-]
  [[nodiscard]] constexpr int index() const noexcept { return index_; }
  /// Every level is over.
  [[nodiscard]] constexpr bool is_done() const noexcept { return index_ >= 2 * parameters_.levels; }
  constexpr void reset() noexcept {
    index_ = 0;
    elapsed_ = 0;
    reference_ = T(0);
  }

 private:
  [[nodiscard]] constexpr T ramped(T level) const noexcept {
    return towards(level, reference_, parameters_.slope);
  }
  [[nodiscard]] constexpr T target(int index) const noexcept {
    const int n = parameters_.levels;
    const int m = index < n ? index : 2 * n - 1 - index;
    const T size = parameters_.highest * (T(1) - (T(1) - lowest_share) * T(m) / T(n - 1));
    return index < n ? size : -size;
  }

  Parameters parameters_;
  int index_{0};             ///< of the level [-]
  std::int32_t elapsed_{0};  ///< periods at the level [-]
  T reference_{};            ///< [A]
};

}  // namespace sextant
