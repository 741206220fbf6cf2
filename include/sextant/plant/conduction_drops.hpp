#pragma once

#include <cmath>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/leg_tie.hpp"

namespace sextant {

/// What a switch or diode of the inverter takes while it conducts the current i of its leg: V_t + r |i|,
/// against the current. One pair counts for switches and diodes. None by default.
template <class T = double>
struct ConductionDrops {
  T threshold_voltage{};  ///< V_t [V]
  T slope_resistance{};   ///< r [Ω]

  [[nodiscard]] constexpr bool act() const noexcept {
    return threshold_voltage > T(0) || slope_resistance > T(0);
  }
  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto is_usable = [](T x) { return std::isfinite(x) && x >= T(0); };
    if (!is_usable(threshold_voltage))
      return "the threshold voltage of the inverter must be finite and not below zero";
    return is_usable(slope_resistance)
               ? nullptr
               : "the slope resistance of the inverter must be finite and not below zero";
  }

  /// What the thresholds take of the link's power, V_t Σ|i_x|; the slope takes 3/2 r |i_s|² beside. [W]
  [[nodiscard]] constexpr T threshold_loss(SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    if (threshold_voltage == T(0)) return T(0);
    T sum{};
    for (const T i : phases_of(i_s)) sum += i < T(0) ? -i : i;
    return threshold_voltage * sum;
  }
};

template <class T>
void describe(Description& d, ConductionDrops<T>& p) {
  auto& [threshold, slope] = p;
  d.number("threshold_v", threshold,
           {"V", 0, 1e3,
            "voltage of a switch or diode that conducts, without current; cvode and erk then stop at each "
            "switching and at each zero of a current, fixed in periods in which a current changes its sign, "
            "and exact is fixed; the drive knows of it by drive.inverter.threshold_v; 0: none"});
  d.number("slope_ohm", slope,
           {"ohm", 0, 1e3,
            "by which the voltage of a conducting switch or diode rises with its current; the drive knows of "
            "it by drive.inverter.slope_ohm; 0: none"});
}

}  // namespace sextant
