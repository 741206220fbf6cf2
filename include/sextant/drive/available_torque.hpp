#pragma once

#include <limits>

#include "sextant/core/derating_cause.hpp"
#include "sextant/core/torque_range.hpp"

namespace sextant {

/// A share of the torque in [0, 1] and what limits it to that.
template <class T = double>
struct LimitedShare {
  T share{1};  ///< [-]
  DeratingCause cause{DeratingCause::none};
};

/// The smaller one, of equal ones the first.
template <class T>
[[nodiscard]] constexpr LimitedShare<T> least(const LimitedShare<T>& a, const LimitedShare<T>& b) noexcept {
  return b.share < a.share ? b : a;
}

/// A magnitude of torque and what limits it.
template <class T = double>
struct LimitedTorque {
  T torque{std::numeric_limits<T>::infinity()};  ///< magnitude [N·m]
  DeratingCause cause{DeratingCause::none};

  /// Lowers the magnitude to that of another limit where it is above it.
  constexpr void lower_to(LimitedTorque limit) noexcept {
    if (torque > limit.torque) *this = limit;
  }
  /// Lowers the magnitude to a share of what it is.
  constexpr void lower_by(const LimitedShare<T>& limit) noexcept {
    lower_to({limit.share * torque, limit.cause});
  }
};

/// Available torque at a speed, when motoring and when regenerating.
template <class T = double>
struct AvailableTorque {
  LimitedTorque<T> motoring{};
  LimitedTorque<T> regenerating{};

  /// The available range at this speed [rad/s]; its sign decides which direction is motoring.
  [[nodiscard]] constexpr TorqueRange<T> range(T omega_m) const noexcept {
    if (omega_m > T(0)) return {-regenerating.torque, motoring.torque};
    if (omega_m < T(0)) return {-motoring.torque, regenerating.torque};
    return {-motoring.torque, motoring.torque};
  }

  /// The side of a torque [N·m] at this speed [rad/s].
  [[nodiscard]] constexpr const LimitedTorque<T>& side(T torque, T omega_m) const noexcept {
    return torque * omega_m < T(0) ? regenerating : motoring;
  }
  [[nodiscard]] constexpr LimitedTorque<T>& side(T torque, T omega_m) noexcept {
    return torque * omega_m < T(0) ? regenerating : motoring;
  }
};

}  // namespace sextant
