#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A driver that follows a vehicle speed by the motors' torque, for braking too: a proportional and
/// integral controller with feed-forward of the acceleration, sampled and held,
///   F = m (dv_ref/dt + omega_b (e + 1/T_i ∫e dt)),   e = v_ref − v,   torque = F r/n.
/// dv_ref/dt is the difference over the last period. The integral is held while the torque is at its limit
/// and the error pulls further. What slows the vehicle is left to the integral.
///
/// With a friction brake the motors brake with what is available of regenerating torque, below
/// `regeneration_from` with the share v/regeneration_from of it, and the brake does the rest. At rest it
/// holds the vehicle with all of its torque, until the reference rises.
class Driver {
 public:
  struct Parameters {
    std::int64_t period_ns{10'000'000};  ///< between two decisions [ns]
    double mass{200};                    ///< m, accelerated by all motors, what turns included [kg]
    double wheel_radius{0.3};            ///< r [m]
    int motors{2};                       ///< n [-]
    double bandwidth{4};                 ///< omega_b of the speed loop [rad/s]
    double integral_time{1};             ///< T_i [s]
    double torque_limit{100};            ///< of each motor, both ways [N·m]
    double brake_torque{};       ///< largest one of the friction brake, at each motor's shaft; 0: none [N·m]
    double regeneration_from{};  ///< speed from which on the motors brake with all that they can [m/s]

    /// nullptr when usable, else what is wrong.
    [[nodiscard]] const char* validate() const noexcept {
      const auto above_zero = [](double x) { return std::isfinite(x) && x > 0; };
      if (period_ns < 1) return "the driver's period must be at least 1 ns";
      if (!above_zero(mass)) return "the driver's idea of the mass must be above zero";
      if (!above_zero(wheel_radius)) return "the wheel radius must be above zero";
      if (motors < 1) return "there must be at least one motor";
      if (!above_zero(bandwidth)) return "the driver's bandwidth must be above zero";
      // Beyond it the loop rings, and diverges at twice of it.
      if (bandwidth * double(period_ns) * 1e-9 > 1)
        return "the driver's bandwidth is too high for the period";
      if (!above_zero(integral_time)) return "the driver's integral time must be above zero";
      if (!above_zero(torque_limit)) return "the driver's torque limit must be above zero";
      if (!(std::isfinite(brake_torque) && brake_torque >= 0))
        return "the torque of the friction brake must not be below zero";
      return std::isfinite(regeneration_from) && regeneration_from >= 0
                 ? nullptr
                 : "the speed of full regeneration must not be below zero";
    }
  };

  /// The parameters must be valid.
  explicit Driver(const Parameters& parameters) noexcept
      : p_{parameters}, torque_per_force_{parameters.wheel_radius / parameters.motors} {}

  /// Torque of each motor at t_ns, held between the decisions. t_ns must not fall. [m/s] → [N·m]
  double step(std::int64_t t_ns, double v_ref, double v) noexcept SEXTANT_NONBLOCKING {
    if (started_ && t_ns < next_ns_) return torque_;
    // Since the last decision, which is late where the caller's steps do not divide the period.
    const double period = double(started_ ? t_ns - last_ns_ : p_.period_ns) * 1e-9;
    const double acceleration = started_ ? (v_ref - last_v_ref_) / period : 0.0;
    // On the grid of the first decision; a period that is missed altogether is not made up for.
    next_ns_ = started_ && t_ns < next_ns_ + p_.period_ns ? next_ns_ + p_.period_ns : t_ns + p_.period_ns;
    started_ = true;
    last_ns_ = t_ns;
    last_v_ref_ = v_ref;

    const double error = v_ref - v;
    const double gain = p_.mass * torque_per_force_;
    const double wanted = gain * (acceleration + p_.bandwidth * (error + integral_ / p_.integral_time));
    torque_ = std::clamp(wanted, -p_.torque_limit, p_.torque_limit);
    bool made = torque_ == wanted;
    if (p_.brake_torque > 0) made = brake(wanted, v_ref, v);
    if (made || (wanted > 0) != (error > 0)) integral_ += error * period;
    return torque_;
  }

  /// The torque of the last decision. [N·m]
  [[nodiscard]] double torque() const noexcept SEXTANT_NONBLOCKING { return torque_; }

  /// Of the friction brake, by the last decision, at each motor's shaft. [N·m]
  [[nodiscard]] double brake_torque() const noexcept SEXTANT_NONBLOCKING { return brake_; }

  /// Sets the torque that a motor has available against its rotation. [N·m]
  void note_regenerating(double torque) noexcept SEXTANT_NONBLOCKING { regenerating_ = torque; }

  /// When the next decision is due; before the first, 0. [ns]
  [[nodiscard]] std::int64_t next_decision_ns() const noexcept SEXTANT_NONBLOCKING { return next_ns_; }

  /// The speed of the vehicle whose wheels turn with omega_m. [rad/s] → [m/s]
  [[nodiscard]] double vehicle_speed(double omega_m) const noexcept SEXTANT_NONBLOCKING {
    return p_.wheel_radius * omega_m;
  }

  /// The speed of the wheels of a vehicle that moves with v. [m/s] → [rad/s]
  [[nodiscard]] double wheel_speed(double v) const noexcept SEXTANT_NONBLOCKING {
    return v / p_.wheel_radius;
  }

  void reset() noexcept { *this = Driver{p_}; }

 private:
  /// At a speed no larger a vehicle that is to rest does so. [m/s]
  static constexpr double rest_speed = 0.02;

  /// Divides a torque among motor and brake; false where both together do not make it. [N·m], [m/s]
  bool brake(double wanted, double v_ref, double v) noexcept SEXTANT_NONBLOCKING {
    brake_ = 0.0;
    if (v_ref == 0.0 && std::abs(v) <= rest_speed) {
      torque_ = integral_ = 0.0;
      brake_ = p_.brake_torque;
      return false;
    }
    if (wanted * v >= 0.0) return torque_ == wanted;
    const double faded = p_.regeneration_from > 0 ? std::min(1.0, std::abs(v) / p_.regeneration_from) : 1.0;
    const double most = faded * std::min(p_.torque_limit, regenerating_);
    torque_ = std::clamp(wanted, -most, most);
    brake_ = std::min(p_.brake_torque, std::abs(wanted - torque_));
    return std::abs(torque_) + brake_ >= std::abs(wanted);
  }

  Parameters p_;
  double torque_per_force_;                                       ///< r/n [m]
  std::int64_t next_ns_{0};                                       ///< [ns]
  std::int64_t last_ns_{0};                                       ///< of the last decision [ns]
  double last_v_ref_{0};                                          ///< [m/s]
  double integral_{0};                                            ///< of the error [m]
  double torque_{0};                                              ///< [N·m]
  double brake_{0};                                               ///< [N·m]
  double regenerating_{std::numeric_limits<double>::infinity()};  ///< available [N·m]
  bool started_{false};
};

}  // namespace sextant
