#pragma once

#include <limits>

namespace sextant {

/// The values of the compared error at which a comparator leaves its present state, in the error's units.
/// At equality the output holds. Infinite: no threshold.
template <class T = double>
struct Thresholds {
  T above{std::numeric_limits<T>::infinity()};   ///< crossed when the error exceeds it: crossing 0
  T below{-std::numeric_limits<T>::infinity()};  ///< crossed when the error falls below it: crossing 1

  /// Number of the threshold that `error` has crossed, or −1.
  [[nodiscard]] constexpr int crossing(T error) const noexcept {
    if (error > above) return 0;
    return error < below ? 1 : -1;
  }
};

/// Sampled operation of a comparator: applies `on_crossing` until no threshold is crossed. An error that
/// jumps over the whole band within one sample crosses two thresholds of a three-level comparator.
template <class Comparator, class T>
constexpr void settle(Comparator& comparator, T error) noexcept {
  for (int passes = 0; passes < 2; ++passes) {
    const int crossing = comparator.thresholds().crossing(error);
    if (crossing < 0) return;
    comparator.on_crossing(crossing);
  }
}

}  // namespace sextant
