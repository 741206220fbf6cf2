#pragma once

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/smooth_state.hpp"

namespace sextant {

/// The parabola that stands for a voltage integral over a step: it has the same ends and the same area. That
/// of a parabola is (begin + 4 middle + end)/6 of its length.
template <class T = double>
class VoltageParabola {
 public:
  /// V and A at both ends of a step of h [s].
  VoltageParabola(const VoltageMoments<T>& begin, const VoltageMoments<T>& end,
                  T h) noexcept SEXTANT_NONBLOCKING
      : rise_{end.v - begin.v},
        middle_{(T(1.5) / h) * (end.a - begin.a - h * begin.v) - T(0.25) * rise_} {}

  /// From the beginning to the middle. [Wb]
  [[nodiscard]] SpaceVector<T> middle() const noexcept SEXTANT_NONBLOCKING { return middle_; }
  /// From the beginning to the end. [Wb]
  [[nodiscard]] SpaceVector<T> rise() const noexcept SEXTANT_NONBLOCKING { return rise_; }

 private:
  SpaceVector<T> rise_;
  SpaceVector<T> middle_;
};

}  // namespace sextant
