#pragma once

#include <cmath>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// What a vehicle does to the shaft of one of its motors: a torque that depends on the speed, positive
/// against positive rotation, and an inertia. Zero throughout by default.
///   tau = k_d omega |omega| + tau_r omega/√(omega² + omega_0²) + tau_g
/// The sign of the rolling torque is smoothed by omega_0, so that the equation stays differentiable.
template <class T = double>
struct RoadLoad {
  T quadratic_drag{};   ///< k_d, air [N·m·s²/rad²]
  T rolling_torque{};   ///< tau_r, reached well above the rolling speed [N·m]
  T rolling_speed{1};   ///< omega_0, at which 71 % of it act [rad/s]
  T grade_torque{};     ///< tau_g, above zero uphill [N·m]
  T coupled_inertia{};  ///< moves with the shaft, beside the rotor's [kg·m²]

  /// True when a torque can act.
  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING {
    return quadratic_drag != T(0) || rolling_torque != T(0) || grade_torque != T(0);
  }

  /// Torque at a mechanical speed. [rad/s] → [N·m]
  [[nodiscard]] T torque(T omega) const noexcept SEXTANT_NONBLOCKING {
    return quadratic_drag * omega * std::abs(omega) +
           rolling_torque * omega / std::sqrt(omega * omega + rolling_speed * rolling_speed) + grade_torque;
  }

  /// Its derivative by the speed. [rad/s] → [N·m·s/rad]
  [[nodiscard]] T slope(T omega) const noexcept SEXTANT_NONBLOCKING {
    const T square = rolling_speed * rolling_speed;
    const T sum = omega * omega + square;
    return T(2) * quadratic_drag * std::abs(omega) + rolling_torque * square / (sum * std::sqrt(sum));
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto at_least_zero = [](T x) { return std::isfinite(x) && x >= T(0); };
    if (!at_least_zero(quadratic_drag)) return "the quadratic drag must be finite and not below zero";
    if (!at_least_zero(rolling_torque)) return "the rolling torque must be finite and not below zero";
    if (!(at_least_zero(rolling_speed) && rolling_speed > T(0)))
      return "the rolling speed must be above zero";
    if (!std::isfinite(grade_torque)) return "the grade torque must be finite";
    return at_least_zero(coupled_inertia) ? nullptr : "the coupled inertia must be finite and not below zero";
  }
};

}  // namespace sextant
