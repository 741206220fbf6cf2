#pragma once

#include <cstdint>

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Phasors of current and voltage over whole cycles of a sine sin φ: with x = a sin φ + b cos φ the value
/// (a, b) is
///   2/N Σ x (sin φ, cos φ)
/// as running means, so that `float` suffices.
template <class T = double>
class ToneMeasurement {
 public:
  /// One period: current [A], commanded mean voltage [V], (cos φ, sin φ).
  constexpr void add(T i, T u, SpaceVector<T> phase) noexcept {
    ++count_;
    const T share = T(1) / T(count_);
    const SpaceVector<T> swapped{phase.beta, phase.alpha};
    current_ += share * ((T(2) * i) * swapped - current_);
    voltage_ += share * ((T(2) * u) * swapped - voltage_);
  }

  [[nodiscard]] constexpr SpaceVector<T> current() const noexcept { return current_; }  ///< [A]
  [[nodiscard]] constexpr SpaceVector<T> voltage() const noexcept { return voltage_; }  ///< [V]

 private:
  std::int32_t count_{0};     ///< periods [-]
  SpaceVector<T> current_{};  ///< of sine and cosine [A]
  SpaceVector<T> voltage_{};  ///< the same [V]
};

}  // namespace sextant
