#pragma once

namespace sextant {

/// What turns behind the motor's shaft at one instant, referred to that shaft (`Driveline`). Where the load
/// is on the shaft itself, this is the load torque and the motor's speed.
struct LoadSample {
  double shaft_torque{};  ///< drives the load and brakes the motor [N·m]
  double speed{};         ///< of the load [rad/s]

  /// On the straight line from a to b.
  [[nodiscard]] static constexpr LoadSample between(const LoadSample& a, const LoadSample& b,
                                                    double share) noexcept {
    return {a.shaft_torque + share * (b.shaft_torque - a.shaft_torque),
            a.speed + share * (b.speed - a.speed)};
  }
};

}  // namespace sextant
