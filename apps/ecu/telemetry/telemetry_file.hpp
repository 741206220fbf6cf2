#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "sextant/control/controller.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/recording/telemetry_csv.hpp"
#include "sextant/recording/trace_recorder.hpp"

namespace sextant::ecu {

/// Telemetry into a file: CSV, or HDF5 in the layout of a recording.
class TelemetryFile {
 public:
  /// By the end of its name, .csv or .h5. For a control period [ns], a number of them in a record [-] and the
  /// beginning of the run, if it is known [ns]. channels: of the controller, for the group `control` of HDF5.
  /// Throws std::runtime_error where the name ends otherwise or the file cannot be made.
  TelemetryFile(const std::string& file, std::int64_t period_ns, std::uint32_t periods_per_record,
                std::optional<std::int64_t> begin_ns, std::span<const ControlChannel> channels = {});

  /// channels: their values at the end of the record.
  void add(const TelemetryIntervalRecord<double>& record, std::span<const double> channels = {});
  /// Throws std::runtime_error where something could not be written.
  void close();

 private:
  std::optional<TelemetryCsv> csv_{};
  std::optional<TraceRecorder> trace_{};
};

}  // namespace sextant::ecu
