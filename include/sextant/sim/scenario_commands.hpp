#pragma once

#include <cstdint>
#include <limits>

#include "sextant/core/drive_request.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/sim/profile.hpp"

namespace sextant {

/// The vehicle of a scenario: plays a torque profile to the drive as an always-healthy bus would, one
/// command a period. Before time zero it goes through the hand-shake of the contract, a disable and then an
/// enable without torque, so that the drive produces torque from time zero on.
class ScenarioCommands {
 public:
  /// Periods before time zero that the hand-shake takes: INIT, STANDBY, READY, TORQUE.
  static constexpr int hand_shake_periods = 4;

  explicit ScenarioCommands(const ProfileParameters& torque_reference) : torque_{torque_reference} {}

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    DriveRequest<double> request;
    request.command = {.torque = reference(t_ns),
                       .torque_limit = std::numeric_limits<double>::max(),
                       .enable = sequence_ + 1 >= hand_shake_periods,
                       .received_ns = t_ns,
                       .sequence = ++sequence_,
                       .e2e = E2eState::valid};
    return request;
  }

  /// The scenario's torque reference at t_ns. [N·m]
  [[nodiscard]] double reference(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    return t_ns < 0 ? 0.0 : torque_.value(t_ns);
  }

 private:
  Profile torque_;
  std::uint32_t sequence_{0};
};

}  // namespace sextant
