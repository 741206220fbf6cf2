#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/profiles/driver.hpp"
#include "sextant/profiles/profile.hpp"
#include "sextant/run/scenario.hpp"

namespace sextant {

/// The torque reference of an event-exact run: a profile, or what a driver makes of a speed profile.
class EventExactReference {
 public:
  /// The reference from an instant on.
  struct Line {
    double torque{};        ///< [N·m]
    double slope{};         ///< [N·m/s]
    std::int64_t end_ns{};  ///< where the line ends [ns]
  };

  explicit EventExactReference(const Scenario& scenario)
      : profile_{scenario.cycle ? scenario.cycle->speed : scenario.torque_reference} {
    if (scenario.cycle) driver_.emplace(scenario.cycle->driver);
  }

  /// At t_ns, with the motor's speed there. [rad/s]
  [[nodiscard]] Line at(std::int64_t t_ns, double omega_m) noexcept {
    if (!driver_) return {profile_.value(t_ns), profile_.slope(t_ns), profile_.next_corner_ns(t_ns)};
    const double torque = driver_->step(t_ns, profile_.value(t_ns), driver_->vehicle_speed(omega_m));
    return {torque, 0.0, std::max(driver_->next_decision_ns(), t_ns + 1)};
  }

  /// Speed that the motor shall have, where a driver follows one; else NaN. [rad/s]
  [[nodiscard]] double speed(std::int64_t t_ns) const noexcept {
    if (!driver_) return std::numeric_limits<double>::quiet_NaN();
    return driver_->wheel_speed(profile_.value(t_ns));
  }

 private:
  Profile profile_;  ///< torque reference [N·m], or the driver's speed reference [m/s]
  std::optional<Driver> driver_{};
};

}  // namespace sextant
