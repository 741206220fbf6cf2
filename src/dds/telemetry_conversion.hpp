#pragma once

#include "sextant/comms/telemetry_samples.hpp"
#include "sextant/comms/waveform_batch.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "telemetry.h"

namespace sextant {

// From plain structs to the generated types; drive_id and sequence are the writer's. False where a value is
// NaN or infinite.

[[nodiscard]] bool convert(const TelemetryIntervalRecord<double>& in, std::uint64_t dropped,
                           sextant_DriveTelemetry& out) noexcept;
[[nodiscard]] bool convert(const DriveStateSample& in, sextant_DriveState& out) noexcept;
[[nodiscard]] bool convert(const RealTimeSample& in, sextant_RealTimeStatistics& out) noexcept;
/// The sequences of `out` refer to those of `in`. Always true.
[[nodiscard]] bool convert(const WaveformBatch& in, std::uint64_t dropped,
                           sextant_DriveWaveform& out) noexcept;

}  // namespace sextant
