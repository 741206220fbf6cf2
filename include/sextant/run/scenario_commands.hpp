#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/core/drive_request.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/profiles/driver.hpp"
#include "sextant/profiles/profile.hpp"
#include "sextant/run/scenario.hpp"

namespace sextant {

/// The vehicle of a scenario: plays a torque profile to the drive, or what a driver makes of a speed profile,
/// as an always-healthy bus would, one command a period. Before time zero it goes through the hand-shake of
/// the contract, a disable and then an enable without torque, so that the drive produces torque from time
/// zero on.
class ScenarioCommands {
 public:
  /// Periods before time zero that the hand-shake takes: INIT, STANDBY, READY, TORQUE.
  static constexpr int hand_shake_periods = 4;

  explicit ScenarioCommands(const ProfileParameters& torque_reference) : profile_{torque_reference} {}
  explicit ScenarioCommands(const Scenario& scenario)
      : profile_{scenario.cycle ? scenario.cycle->speed : scenario.torque_reference} {
    if (scenario.cycle) driver_.emplace(scenario.cycle->driver);
  }

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    if (driver_ && t_ns >= 0) driver_->step(t_ns, profile_.value(t_ns), driver_->vehicle_speed(omega_m_));
    DriveRequest<double> request;
    request.command = {.torque = reference(t_ns),
                       .torque_limit = std::numeric_limits<double>::max(),
                       .enable = sequence_ + 1 >= hand_shake_periods,
                       .received_ns = t_ns,
                       .sequence = ++sequence_,
                       .e2e = E2eState::valid};
    return request;
  }

  /// The scenario's torque reference at t_ns; with a driver, the newest. [N·m]
  [[nodiscard]] double reference(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    if (t_ns < 0) return 0.0;
    return driver_ ? driver_->torque() : profile_.value(t_ns);
  }

  /// How the torque reference goes on from t_ns to its next corner; a driver's is constant. [N·m/s]
  [[nodiscard]] double reference_slope(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    return driver_ ? 0.0 : profile_.slope(t_ns);
  }

  /// The shaft's speed that a driver aims at; NaN without one. [rad/s]
  [[nodiscard]] double speed_reference(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    return driver_ ? driver_->wheel_speed(profile_.value(t_ns)) : std::numeric_limits<double>::quiet_NaN();
  }

  /// Sets the measured speed, for the driver. [rad/s]
  void note_speed(double omega_m) noexcept SEXTANT_NONBLOCKING { omega_m_ = omega_m; }

  /// Sets the torque that the drive has available against the rotation, for a driver with a brake. [N·m]
  void note_regenerating(double torque) noexcept SEXTANT_NONBLOCKING {
    if (driver_) driver_->note_regenerating(torque);
  }

  /// Of the friction brake, by a driver; zero without one. [N·m]
  [[nodiscard]] double brake_torque() const noexcept SEXTANT_NONBLOCKING {
    return driver_ ? driver_->brake_torque() : 0.0;
  }

 private:
  Profile profile_;  ///< torque reference [N·m], or the driver's speed reference [m/s]
  std::optional<Driver> driver_{};
  double omega_m_{0};  ///< [rad/s]
  std::uint64_t sequence_{0};
};

}  // namespace sextant
