#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A friction brake on a shaft, Coulomb's law: a moving shaft it brakes with its torque, whatever the speed;
/// a shaft at rest it holds against any torque up to that. Evaluated at instants between which the plant is
/// integrated, so that a shaft comes to rest within one of these pieces.
class FrictionBrake {
 public:
  /// What it does from an instant on.
  struct Action {
    bool holds{false};  ///< the shaft stays at rest
    double torque{};    ///< against positive rotation, of a shaft that moves [N·m]
  };

  /// Its torque, not below zero, from the next instant on. [N·m]
  void set(double torque) noexcept SEXTANT_NONBLOCKING {
    torque_ = torque;
    if (torque > 0.0 && !energy_) energy_ = 0.0;
  }

  /// False for a brake that has never been used.
  [[nodiscard]] bool acts() const noexcept SEXTANT_NONBLOCKING { return energy_.has_value(); }

  /// At t_ns, with the shaft's speed [rad/s] and the torque of everything else in its direction [N·m].
  [[nodiscard]] Action step(std::int64_t t_ns, double omega_m, double other) noexcept SEXTANT_NONBLOCKING {
    meter(t_ns, omega_m);
    if (!(torque_ > 0.0)) return action_ = {};
    const bool rests = action_.holds || omega_m == 0.0 || omega_m * last_omega_ < 0.0;
    last_omega_ = omega_m;
    if (!rests) return action_ = {false, std::copysign(torque_, omega_m)};
    if (std::abs(other) > torque_) return action_ = {false, std::copysign(torque_, other)};
    last_omega_ = 0.0;
    return action_ = {true, 0.0};
  }

  /// What it has done since the last instant.
  [[nodiscard]] const Action& action() const noexcept SEXTANT_NONBLOCKING { return action_; }

  /// Turned into heat so far, ∫|torque omega_m| dt by the trapezoidal rule; empty where it has never been
  /// used. [J]
  [[nodiscard]] const std::optional<double>& energy() const noexcept SEXTANT_NONBLOCKING { return energy_; }

 private:
  void meter(std::int64_t t_ns, double omega_m) noexcept SEXTANT_NONBLOCKING {
    const double seconds = double(t_ns - last_ns_) * 1e-9;
    if (action_.torque != 0.0)
      energy_ = energy_.value_or(0.0) + 0.5 * action_.torque * (last_omega_ + omega_m) * seconds;
    last_ns_ = t_ns;
    if (!(torque_ > 0.0)) last_omega_ = omega_m;
  }

  double torque_{};
  Action action_{};
  std::optional<double> energy_{};
  double last_omega_{};     ///< at the last instant [rad/s]
  std::int64_t last_ns_{};  ///< [ns]
};

}  // namespace sextant
