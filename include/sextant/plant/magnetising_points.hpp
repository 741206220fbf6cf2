#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "sextant/core/description.hpp"

namespace sextant {

/// Saturation of the main flux by a measured no-load curve, in the place of the law of
/// `SaturationParameters`; none by default. In the Γ circuit, all leakage on the rotor's side, the
/// magnetising current is the one at no load: the points are (stator flux linkage [Wb], amplitude of that
/// current [A]), both rising, without the zero that the curve begins with (`MagnetisingTable`).
template <class T = double>
struct MagnetisingPoints {
  std::vector<std::pair<T, T>> points{};

  static constexpr std::size_t least = 2;  ///< points of a curve
  static constexpr std::size_t most = 24;
  /// Of the curve by the L_s of the machine's parameters, at most. [-]
  static constexpr T largest_ratio = T(10);

  friend bool operator==(const MagnetisingPoints&, const MagnetisingPoints&) noexcept = default;

  [[nodiscard]] bool acts() const noexcept { return !points.empty(); }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!acts()) return nullptr;
    if (points.size() < least || points.size() > most)
      return "the points of the saturation must be none, or from 2 to 24";
    std::pair<T, T> before{};
    for (const auto& [psi, current] : points) {
      if (!(std::isfinite(psi) && std::isfinite(current) && psi > before.first && current > before.second))
        return "the points of the saturation must rise from above zero in flux and current";
      before = {psi, current};
    }
    const auto& [psi_a, current_a] = points[points.size() - 2];
    const auto& [psi_b, current_b] = points.back();
    // The curve goes on beyond its end in a line, along which the inductance must not grow.
    if (!((current_b - current_a) * psi_b > (psi_b - psi_a) * current_b))
      return "the points of the saturation must end where the current rises more than in proportion to the "
             "flux";
    return nullptr;
  }
};

template <class T>
void describe(Description& d, MagnetisingPoints<T>& p) {
  auto& [points] = p;
  d.points("points", points, {"flux", 1e-6, 1e3}, {"current", 1e-6, 1e6}, "Wb, A",
           "no-load curve in the place of the law of knee_wb: stator flux linkage and amplitude of the "
           "current at no load, both rising from above zero, joined by a monotone cubic curve through zero; "
           "none: the law holds");
}

}  // namespace sextant
