#pragma once

#include <cstdint>

#include "sextant/core/telemetry.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/sim/plant_envelope.hpp"
#include "sextant/sim/trace_row.hpp"

namespace sextant {

/// Reduces control periods to the rows of a trace.
class TraceReducer {
 public:
  explicit TraceReducer(std::uint32_t periods_per_row) noexcept : periods_per_row_{periods_per_row} {}

  /// Adds a control period; true when it completes the row.
  [[nodiscard]] bool add(const Telemetry<>& telemetry, const PlantSample& plant) noexcept {
    drive_.add(telemetry);
    plant_.add(plant);
    last_plant_ = plant;
    return drive_.count() >= periods_per_row_;
  }

  /// True while the row has no control period.
  [[nodiscard]] bool empty() const noexcept { return drive_.count() == 0; }

  /// The row so far, complete or not; the next period begins a new one.
  [[nodiscard]] TraceRow take() noexcept {
    const TraceRow row{.drive = drive_.record(), .plant = plant_.row(last_plant_)};
    drive_.reset();
    plant_.reset();
    return row;
  }

 private:
  std::uint32_t periods_per_row_;
  TelemetryInterval<> drive_{};
  PlantEnvelope plant_{};
  PlantSample last_plant_{};
};

}  // namespace sextant
