#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/torque_range.hpp"

namespace sextant {

/// The torque that may be asked for at a speed, when motoring and when regenerating.
template <class T = double>
struct AvailableTorque {
  T motoring{};      ///< [N·m]
  T regenerating{};  ///< magnitude [N·m]

  /// A magnitude that may be asked for with either sign at any speed: braking gives no less than motoring.
  [[nodiscard]] constexpr T either_way() const noexcept { return motoring; }

  /// The torques that may be asked for at this speed [rad/s], of which the sign tells what motoring is.
  [[nodiscard]] constexpr TorqueRange<T> range(T omega_m) const noexcept {
    if (omega_m > T(0)) return {-regenerating, motoring};
    if (omega_m < T(0)) return {-motoring, regenerating};
    return {-motoring, motoring};
  }
};

/// Torque over speed: full torque up to the base speed; beyond it, motoring torque falls linearly to nothing
/// at the zero-torque speed, because the link voltage no longer overcomes the EMF. Braking keeps full torque.
template <class T = double>
class TorqueCapability {
 public:
  struct Parameters {
    T torque{T(150)};             ///< up to base speed [N·m]
    T base_speed{T(115)};         ///< mechanical [rad/s]
    T zero_torque_speed{T(180)};  ///< mechanical [rad/s]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(torque) && torque > T(0))) return "the available torque must be above zero";
      if (!(std::isfinite(base_speed) && base_speed > T(0))) return "the base speed must be above zero";
      if (!(std::isfinite(zero_torque_speed) && zero_torque_speed > base_speed)) {
        return "the zero-torque speed must be above the base speed";
      }
      return nullptr;
    }
  };

  constexpr explicit TorqueCapability(const Parameters& parameters) noexcept
      : parameters_{parameters},
        inverse_range_{T(1) / (parameters.zero_torque_speed - parameters.base_speed)} {}

  /// True up to the base speed, where the full torque is available; false of a NaN.
  [[nodiscard]] constexpr bool is_full(T omega_m) const noexcept {
    return std::abs(omega_m) <= parameters_.base_speed;
  }

  /// Available at mechanical speed omega_m [rad/s]; none while the speed is no number.
  [[nodiscard]] constexpr AvailableTorque<T> at(T omega_m) const noexcept {
    if (is_full(omega_m)) return {parameters_.torque, parameters_.torque};
    if (!std::isfinite(omega_m)) return {};
    const T over = (std::abs(omega_m) - parameters_.base_speed) * inverse_range_;
    return {parameters_.torque * (T(1) - std::clamp(over, T(0), T(1))), parameters_.torque};
  }

 private:
  Parameters parameters_;
  T inverse_range_;  ///< of the speeds over which the torque falls [s/rad]
};

}  // namespace sextant
