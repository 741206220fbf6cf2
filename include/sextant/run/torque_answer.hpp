#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/core/telemetry.hpp"
#include "sextant/drive/available_torque.hpp"
#include "sextant/drive/drive_state_machine.hpp"

namespace sextant {

/// Torque that was asked of a drive and not made: means over the time in which it was asked, counted in the
/// direction of the command.
struct MissingTorque {
  double asked{};      ///< magnitude of the command [N·m]
  double made{};       ///< true torque [N·m]
  DriveState state{};  ///< in the last of these periods
};

/// Whether a sampled run makes any of the torque that is asked in it, from control period to control period,
/// over the stretches that are added and while the command is not zero. What the drive owes is the command
/// within the available range that it publishes in TORQUE and DERATED. The torque is missing where it was
/// asked for 20 ms or longer in all, and
///   the drive was never in TORQUE nor DERATED, or
///   ∫ sgn(c) τ_e dt < 0.05 ∫ |owed| dt, with  ∫ |owed| dt > 0.05 ∫ available dt:
/// less would be lost among the errors that every drive has.
class TorqueAnswer {
 public:
  static constexpr std::int64_t least_ns = 20'000'000;  ///< time of torque from which on a run is judged [ns]
  static constexpr double least_share = 0.05;           ///< of what is owed; below it there is none [-]

  /// Adds a stretch of the present period, along which the true torque [N·m] runs linearly.
  void add_segment(double torque_begin, double torque_end, double duration_ns) noexcept {
    area_ += 0.5 * (torque_begin + torque_end) * duration_ns;
    elapsed_ns_ += duration_ns;
  }

  /// Ends the present period and begins that of `telemetry`, with the commanded torque [N·m].
  void begin_period(const Telemetry<double>& telemetry, double command) noexcept {
    end_period();
    area_ = elapsed_ns_ = 0;
    state_ = telemetry.state;
    command_ = command;
    available_ = {.motoring = {.torque = telemetry.torque_motoring},
                  .regenerating = {.torque = telemetry.torque_regenerating}};
    omega_m_ = telemetry.omega_m;
  }

  /// Empty where torque was made, or hardly any was asked.
  [[nodiscard]] std::optional<MissingTorque> missing() const noexcept {
    if (asked_ns_ < double(least_ns)) return std::nullopt;
    const bool is_owed = owed_ > least_share * offered_;
    if (has_begun_ && !(is_owed && made_ < least_share * owed_)) return std::nullopt;
    return MissingTorque{.asked = asked_ / asked_ns_, .made = made_ / asked_ns_, .state = last_state_};
  }

 private:
  void end_period() noexcept {
    if (command_ == 0 || elapsed_ns_ <= 0) return;
    const double side = available_.side(command_, omega_m_).torque;
    asked_ns_ += elapsed_ns_;
    asked_ += std::abs(command_) * elapsed_ns_;
    made_ += command_ > 0 ? area_ : -area_;
    last_state_ = state_;
    if (!makes_torque(state_)) return;
    has_begun_ = true;
    owed_ += std::min(std::abs(command_), side) * elapsed_ns_;
    offered_ += side * elapsed_ns_;
  }

  DriveState state_{};                   // of the present period
  double command_{0};                    // in the present period [N·m]
  AvailableTorque<double> available_{};  // in the present period
  double omega_m_{0};                    // in the present period [rad/s]
  double area_{0};                       // of the true torque over the present period [N·m·ns]
  double elapsed_ns_{0};                 // of the present period
  DriveState last_state_{};              // of the last period with a command
  bool has_begun_{false};
  double asked_ns_{0};  // time with a command
  double asked_{0};     // of the following, sums over that time [N·m·ns]
  double made_{0};
  double owed_{0};
  double offered_{0};
};

}  // namespace sextant
