#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "sextant/core/nonblocking.hpp"
#include "sextant/profiles/profile.hpp"

namespace sextant {

/// What the shaft is connected to: a load torque, or a machine that imposes the speed.
class MechanicalLoad {
 public:
  struct Parameters {
    ProfileParameters load_torque{};                   ///< opposes positive rotation [N·m]
    std::optional<ProfileParameters> imposed_speed{};  ///< mechanical; replaces the load torque [rad/s]
    bool torque_begins_at_zero{false};                 ///< before time zero there is no load torque [-]
  };

  /// Throws std::runtime_error when a profile is malformed.
  explicit MechanicalLoad(const Parameters& parameters)
      : load_torque_{parameters.load_torque}, torque_begins_at_zero_{parameters.torque_begins_at_zero} {
    if (parameters.imposed_speed) imposed_speed_.emplace(*parameters.imposed_speed);
  }

  [[nodiscard]] bool imposes_speed() const noexcept { return imposed_speed_.has_value(); }

  /// Load torque at t_ns. [N·m]
  [[nodiscard]] double torque(std::int64_t t_ns) const noexcept {
    return t_ns < 0 && torque_begins_at_zero_ ? 0.0 : load_torque_.value(t_ns);
  }

  /// Imposed speed at t_ns. [rad/s]
  [[nodiscard]] double speed(std::int64_t t_ns) const noexcept {
    return imposed_speed_ ? imposed_speed_->value(t_ns) : 0.0;
  }

  /// Its right-hand derivative at t_ns. [rad/s²]
  [[nodiscard]] double speed_slope(std::int64_t t_ns) const noexcept {
    return imposed_speed_ ? imposed_speed_->slope(t_ns) : 0.0;
  }

  /// The first instant after t_ns at which a profile jumps or changes its slope. [ns]
  [[nodiscard]] std::int64_t next_corner_ns(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    const std::int64_t torque_ns = load_torque_.next_corner_ns(t_ns);
    return imposed_speed_ ? std::min(torque_ns, imposed_speed_->next_corner_ns(t_ns)) : torque_ns;
  }

 private:
  Profile load_torque_;
  std::optional<Profile> imposed_speed_{};
  bool torque_begins_at_zero_;
};

}  // namespace sextant
