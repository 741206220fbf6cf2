#pragma once

#include <cmath>

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

}  // namespace sextant
