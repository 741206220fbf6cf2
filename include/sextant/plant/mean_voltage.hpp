#pragma once

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/smooth_state.hpp"
#include "sextant/plant/voltage_integral.hpp"

namespace sextant {

/// What stands for the integral V of the stator voltage and for A = ∫ V dt over gate segments: a straight
/// line and its integral, each raised by a constant to the mean of what it stands for. Unlike V they run
/// nearly straight on from period to period under a modulated voltage, whatever the pattern is within them.
template <class T = double>
class MeanVoltage {
 public:
  /// V and A where the segments begin.
  MeanVoltage(const VoltageMoments<T>& begin,
              const VoltageIntegral<T>& voltage) noexcept SEXTANT_NONBLOCKING {
    const T h = voltage.duration();
    const SpaceVector<T> rise = voltage.end().v;
    const SpaceVector<T> above = (T(1) / h) * voltage.end().a - T(0.5) * rise;
    const SpaceVector<T> area = T(0.5) * (h * above) + (h / T(6)) * rise;
    u_mean_ = (T(1) / h) * rise;
    v_ = begin.v + above;
    a_ = begin.a + (T(1) / h) * voltage.area_of_a() - area;
  }

  /// V and A by the line at the time t after its beginning [s].
  [[nodiscard]] VoltageMoments<T> operator()(T t) const noexcept SEXTANT_NONBLOCKING {
    return {v_ + t * u_mean_, a_ + t * (v_ + (T(0.5) * t) * u_mean_)};
  }

 private:
  SpaceVector<T> u_mean_{};  ///< [V]
  SpaceVector<T> v_{};       ///< of the line where it begins [Wb]
  SpaceVector<T> a_{};       ///< of A there [Wb·s]
};

}  // namespace sextant
