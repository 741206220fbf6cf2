#pragma once

#include <algorithm>
#include <cstdint>

#include "sextant/core/telemetry.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/recording/plant_envelope.hpp"
#include "sextant/recording/trace_row.hpp"

namespace sextant {

/// Reduces control periods to the rows of a trace.
class TraceReducer {
 public:
  explicit TraceReducer(std::uint32_t periods_per_row) noexcept : periods_per_row_{periods_per_row} {}

  /// Adds a gate segment of the control period to come: the plant at both of its ends, and its length [s].
  void add_segment(const PlantSample& before, const PlantSample& after, double seconds) noexcept {
    plant_.add_segment(before, after, seconds);
  }

  /// Adds a control period, with the plant at its end; true when it completes the row.
  [[nodiscard]] bool add(const Telemetry<>& telemetry, const PlantSample& plant,
                         const ControlSample& control = {}) noexcept {
    drive_.add(telemetry);
    last_plant_ = plant;
    control_.torque_comparator = control.torque_comparator;
    control_.flux_comparator = control.flux_comparator;
    control_.torque_monitored_nm = telemetry.torque_monitored;
    control_.torque_reached_nm = telemetry.torque_reached;
    control_.r_s_ohm = telemetry.r_s;
    control_.r_r_ohm = telemetry.r_r;
    control_.l_m_h = telemetry.l_m;
    control_.r_s_deviation = telemetry.r_s_deviation;
    control_.r_r_deviation = telemetry.r_r_deviation;
    control_.l_m_deviation = telemetry.l_m_deviation;
    control_.periods_unchecked = double(telemetry.unchecked_periods);
    std::copy_n(control.channels.begin(), std::min(control.channels.size(), control_.channels.size()),
                control_.channels.begin());
    return drive_.count() >= periods_per_row_;
  }

  /// True while the row has no control period.
  [[nodiscard]] bool empty() const noexcept { return drive_.count() == 0; }

  /// The row so far, complete or not; the next period begins a new one.
  [[nodiscard]] TraceRow take() noexcept {
    const TraceRow row{.drive = drive_.record(), .plant = plant_.row(last_plant_), .control = control_};
    held_ = row.drive;
    drive_.reset();
    plant_.reset();
    return row;
  }

  /// A row without a control period, which ends at t_ns with the plant as it is there. The drive's values are
  /// those of the row before.
  [[nodiscard]] TraceRow take_part(const PlantSample& end, std::int64_t t_ns) noexcept {
    TraceRow row{.drive = held_, .plant = plant_.row(end), .control = control_};
    row.drive.t_ns = t_ns;
    row.drive.periods = 0;
    plant_.reset();
    return row;
  }

 private:
  std::uint32_t periods_per_row_;
  TelemetryInterval<> drive_{};
  PlantEnvelope plant_{};
  PlantSample last_plant_{};
  ControlRow control_{};
  decltype(TraceRow::drive) held_{};  ///< of the row before
};

}  // namespace sextant
