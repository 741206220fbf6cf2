#include "ecu/telemetry/telemetry_file.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace sextant::ecu {

TelemetryFile::TelemetryFile(const std::string& file, std::int64_t period_ns,
                             std::uint32_t periods_per_record, std::optional<std::int64_t> begin_ns,
                             std::span<const ControlChannel> channels) {
  const std::string kind = std::filesystem::path{file}.extension().string();
  if (kind == ".csv") {
    csv_.emplace(file);
  } else if (kind == ".h5" || kind == ".hdf5") {
    const TraceParameters parameters{.interval_us = double(period_ns) * double(periods_per_record) * 1e-3};
    // `close` throws its errors.
    trace_.emplace(file, parameters,
                   TraceOrigin{.scenario = "virtual time",
                               .control_period_ns = period_ns,
                               .channels = channels,
                               .plant = false,
                               .begin_ns = begin_ns},
                   [](const std::string&) {});
  } else {
    throw std::runtime_error{"the telemetry file " + file + " must end in .csv or .h5"};
  }
}

void TelemetryFile::add(const TelemetryIntervalRecord<double>& record, std::span<const double> channels) {
  if (csv_) csv_->add(record);
  if (!trace_) return;
  TraceRow row{.drive = record, .plant = {}, .control = {}};
  std::copy_n(channels.begin(), std::min(channels.size(), row.control.channels.size()),
              row.control.channels.begin());
  trace_->add_row(row);
}

void TelemetryFile::close() {
  if (csv_) csv_->close();
  if (!trace_) return;
  trace_->close();
  if (!trace_->error().empty()) throw std::runtime_error{trace_->error()};
}

}  // namespace sextant::ecu
