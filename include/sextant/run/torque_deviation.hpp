#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "sextant/core/telemetry.hpp"
#include "sextant/drive/available_torque.hpp"
#include "sextant/drive/drive_state_machine.hpp"
#include "sextant/run/sliding_maximum.hpp"
#include "sextant/run/sliding_mean.hpp"

namespace sextant {

/// How far the delivered torque departs from what the drive has been commanded or says that it can deliver,
/// from control period to control period of a sampled run.
///
/// The attainable command of a period is the commanded torque within the available range that the drive
/// publishes in it; it is zero in MAGNETISING, which announces that there is no torque yet. The deviation at
/// the end of a period is the distance of the mean of the true torque over the last 20 ms from the interval
/// of the attainable commands of these 20 ms, so that a step of the command is no deviation by itself; with a
/// constant attainable command c it is |mean(τ_e) − c|. Where the drive says that the voltage holds the
/// torque off its reference (DERATED by VOLTAGE_LIMIT) the torque may lie between the attainable command and
/// what it publishes as reached: either end of the interval is further by the mean over the 20 ms of what the
/// reached torque is beyond the attainable command. The deviation is too large above
///   max(tolerance, 5 % of the nearest attainable command).
/// Gates that are off, as they are after a fault, end a deviation; the mean begins anew after them, and there
/// is no deviation before it spans 20 ms. An entry into DERATED by a limit of the available torque after 20
/// ms without it announces what comes before it: for 20 ms, over which the mean still contains it, a
/// deviation that is too large counts as none. A torque held off its reference announces no more than its
/// interval.
class TorqueDeviation {
 public:
  static constexpr std::int64_t span_ns = 20'000'000;  ///< of the mean [ns]
  static constexpr double relative_tolerance = 0.05;   ///< tolerance by attainable command [-]

  /// Instants within (from_ns, to_ns] count. period_ns is the control period. [ns] tolerance: the least one
  /// of the mean torque. [N·m]
  TorqueDeviation(std::int64_t period_ns, std::int64_t from_ns, std::int64_t to_ns, double tolerance)
      : period_ns_{period_ns},
        from_ns_{from_ns},
        to_ns_{to_ns},
        tolerance_{tolerance},
        torque_{periods(period_ns)},
        highest_{periods(period_ns)},
        negated_lowest_{periods(period_ns)},
        above_{periods(period_ns)},
        below_{periods(period_ns)},
        span_{static_cast<std::int64_t>(periods(period_ns))} {}

  /// Adds a stretch of the present period, along which the true torque [N·m] runs linearly.
  void add_segment(double torque_begin, double torque_end, double duration_ns) noexcept {
    area_ += 0.5 * (torque_begin + torque_end) * duration_ns;
    elapsed_ns_ += duration_ns;
  }

  /// Ends the present period and begins that of `telemetry`, with the commanded torque [N·m].
  void begin_period(const Telemetry<double>& telemetry, double command) noexcept {
    const std::int64_t t_ns = telemetry.t_ns;
    if (elapsed_ns_ > 0) end_period(t_ns > from_ns_ && t_ns <= to_ns_);
    area_ = elapsed_ns_ = 0;
    if (!telemetry.latched.any() && t_ns >= from_ns_ && t_ns <= to_ns_) note_available(telemetry);
    delivers_ = gates_are_on(telemetry.state);
    if (!delivers_) return clear();
    note_derating(telemetry.state == DriveState::derated && !lags(telemetry));
    attainable_ = makes_torque(telemetry.state) ? within_available(telemetry, command) : 0.0;
    lag_ = lags(telemetry) ? telemetry.torque_reached - attainable_ : 0.0;
  }

  /// Largest deviation; NaN where no mean could be formed. [N·m]
  [[nodiscard]] double largest() const noexcept { return has_mean_ ? largest_ : nan; }

  /// Longest time without a pause in which the deviation was too large and not announced; NaN where no mean
  /// could be formed. [ms]
  [[nodiscard]] double longest_ms() const noexcept {
    return has_mean_ ? static_cast<double>(longest_periods_ * period_ns_) * 1e-6 : nan;
  }

  /// Mean of the available torques over the periods without a latched fault; NaN without one. [N·m]
  [[nodiscard]] double motoring() const noexcept { return mean(motoring_); }
  [[nodiscard]] double regenerating() const noexcept { return mean(regenerating_); }

 private:
  /// The command within the published torque.
  [[nodiscard]] static double within_available(const Telemetry<double>& t, double command) noexcept {
    const AvailableTorque<double> available{.motoring = {.torque = t.torque_motoring},
                                            .regenerating = {.torque = t.torque_regenerating}};
    const TorqueRange<double> range = available.range(t.omega_m);
    return std::min(std::max(command, range.lowest), range.highest);
  }

  /// The drive says that the voltage holds the torque off its reference.
  [[nodiscard]] static bool lags(const Telemetry<double>& t) noexcept {
    return t.state == DriveState::derated && t.derating_cause == DeratingCause::voltage_limit &&
           t.torque_reached != t.torque_reference;
  }

  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] static std::size_t periods(std::int64_t period_ns) noexcept {
    return static_cast<std::size_t>(std::max<std::int64_t>(1, (span_ns + period_ns / 2) / period_ns));
  }

  [[nodiscard]] double mean(double sum) const noexcept {
    return available_periods_ > 0 ? sum / static_cast<double>(available_periods_) : nan;
  }

  void clear() noexcept {
    torque_.clear();
    highest_.clear();
    negated_lowest_.clear();
    above_.clear();
    below_.clear();
    too_large_periods_ = 0;
  }

  void note_derating(bool derated) noexcept {
    if (derated && since_derated_ >= span_)
      announced_ = span_;
    else if (announced_ > 0)
      --announced_;
    since_derated_ = derated ? 0 : since_derated_ + 1;
  }

  void end_period(bool counts) noexcept {
    if (!delivers_) return;
    torque_.push(area_ / elapsed_ns_);
    highest_.push(attainable_);
    negated_lowest_.push(-attainable_);
    above_.push(std::max(0.0, lag_));
    below_.push(std::max(0.0, -lag_));
    if (!counts || !torque_.full()) return;
    const double lowest = -negated_lowest_.value() - below_.value();
    const double highest = highest_.value() + above_.value();
    const double nearest = std::min(std::max(torque_.value(), lowest), highest);
    const double deviation = std::abs(torque_.value() - nearest);
    has_mean_ = true;
    largest_ = std::max(largest_, deviation);
    const bool too_large = deviation > std::max(tolerance_, relative_tolerance * std::abs(nearest));
    too_large_periods_ = too_large && announced_ == 0 ? too_large_periods_ + 1 : 0;
    longest_periods_ = std::max(longest_periods_, too_large_periods_);
  }

  void note_available(const Telemetry<double>& telemetry) noexcept {
    motoring_ += telemetry.torque_motoring;
    regenerating_ += telemetry.torque_regenerating;
    ++available_periods_;
  }

  std::int64_t period_ns_;
  std::int64_t from_ns_;
  std::int64_t to_ns_;
  double tolerance_;               // least one of the mean torque [N·m]
  SlidingMean torque_;             // true torque, mean of each period
  SlidingMaximum highest_;         // attainable command
  SlidingMaximum negated_lowest_;  // attainable command with the other sign
  SlidingMean above_;              // of the reached torque over the attainable command
  SlidingMean below_;              // of the attainable command over the reached torque
  std::int64_t span_;              // of the mean [periods]
  double area_{0};                 // of the true torque over the present period [N·m·ns]
  double elapsed_ns_{0};           // of the present period
  double attainable_{0};           // in the present period [N·m]
  double lag_{0};                  // reached torque less attainable command in the present period [N·m]
  bool delivers_{false};           // gates on in the present period
  bool has_mean_{false};           // of 20 ms, in the window
  double largest_{0};              // [N·m]
  std::int64_t since_derated_{std::numeric_limits<std::int64_t>::max() / 2};  // last DERATED [periods]
  std::int64_t announced_{0};                                                 // periods to come
  std::int64_t too_large_periods_{0};
  std::int64_t longest_periods_{0};
  double motoring_{0};      // sum over periods [N·m]
  double regenerating_{0};  // sum over periods [N·m]
  std::int64_t available_periods_{0};
};

}  // namespace sextant
