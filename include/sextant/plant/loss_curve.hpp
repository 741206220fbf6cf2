#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A curve of a data sheet over the current: (current [A], value), joined by straight lines, of which the
/// first and the last go on beyond their ends. Two points make a threshold with a slope.
using LossPoints = std::vector<std::pair<double, double>>;

/// nullptr when the points make a curve, else what is wrong. No points are none.
[[nodiscard]] inline const char* validate_points(const LossPoints& points) noexcept {
  if (points.size() == 1) return "a curve over the current needs two points at least";
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto [current, value] = points[k];
    if (!(std::isfinite(current) && std::isfinite(value) && current >= 0.0 && value >= 0.0))
      return "currents and values of a curve must be finite and not below zero";
    if (k > 0 && !(current > points[k - 1].first))
      return "the currents of a curve must rise from point to point";
  }
  return nullptr;
}

/// A value over the magnitude of the current, at two temperatures, between and beyond which it runs in a
/// line, and not below zero:
///   y(i, ϑ) = y_c(|i|) + (y_h(|i|) − y_c(|i|)) s,   s = (ϑ − ϑ_c)/(ϑ_h − ϑ_c)
/// Without points at the hot one it does not depend on temperature; without any it is zero.
class LossCurve {
 public:
  LossCurve() = default;
  /// Points that `validate_points` takes.
  LossCurve(LossPoints cold, LossPoints hot) : cold_{std::move(cold)}, hot_{std::move(hot)} {}

  /// At a current [A] of either sign, at the share s of the way from cold to hot. [unit of the points]
  [[nodiscard]] double operator()(double i, double s) const noexcept SEXTANT_NONBLOCKING {
    const double magnitude = std::abs(i);
    const double cold = at(cold_, magnitude);
    if (hot_.empty()) return cold;
    return std::max(0.0, cold + (at(hot_, magnitude) - cold) * s);
  }

 private:
  [[nodiscard]] static double at(const LossPoints& points, double i) noexcept SEXTANT_NONBLOCKING {
    if (points.empty()) return 0.0;
    std::size_t k = 1;
    while (k + 1 < points.size() && points[k].first < i) ++k;
    const auto [i_a, y_a] = points[k - 1];
    const auto [i_b, y_b] = points[k];
    return std::max(0.0, y_a + (y_b - y_a) * (i - i_a) / (i_b - i_a));
  }

  LossPoints cold_{};
  LossPoints hot_{};
};

}  // namespace sextant
