#include "sextant/recording/telemetry_csv.hpp"

#include <cerrno>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "trace_columns.hpp"

namespace sextant {
namespace {

[[noreturn]] void refuse(const std::string& file, int error) {
  const std::string reason =
      error == 0 ? "an error of the file system" : std::generic_category().message(error);
  throw std::runtime_error{file + " cannot be written: " + reason};
}

template <class Value>
Value value_of(const TraceColumn& column, const TraceRow& row) {
  Value value{};
  std::memcpy(&value, reinterpret_cast<const char*>(&row) + column.offset, sizeof value);
  return value;
}

void append(std::string& line, const TraceColumn& column, const TraceRow& row) {
  const auto out = std::back_inserter(line);
  switch (column.type) {
    case ColumnType::float64:
      fmt::format_to(out, "{}", value_of<double>(column, row));
      return;
    case ColumnType::int64:
      fmt::format_to(out, "{}", value_of<std::int64_t>(column, row));
      return;
    case ColumnType::uint32:
      fmt::format_to(out, "{}", value_of<std::uint32_t>(column, row));
      return;
    case ColumnType::uint8:
      fmt::format_to(out, "{}", value_of<std::uint8_t>(column, row));
      return;
    case ColumnType::int8:
      fmt::format_to(out, "{}", int(value_of<std::int8_t>(column, row)));
      return;
    case ColumnType::drive_state:
      line += to_string(value_of<DriveState>(column, row));
      return;
  }
}

}  // namespace

TelemetryCsv::TelemetryCsv(std::string file)
    : file_{std::move(file)}, stream_{std::fopen(file_.c_str(), "w")} {
  if (!stream_) refuse(file_, errno);
  for (const TraceColumn& column : drive_columns) {
    line_ += line_.empty() ? "" : ",";
    line_ += column.name;
  }
  line_ += '\n';
  (void)std::fwrite(line_.data(), 1, line_.size(), stream_.get());
}

void TelemetryCsv::add(const TelemetryIntervalRecord<double>& record) {
  if (!stream_ || std::ferror(stream_.get()) != 0) return;
  const TraceRow row{.drive = record, .plant = {}, .control = {}};
  line_.clear();
  for (const TraceColumn& column : drive_columns) {
    if (!line_.empty()) line_ += ',';
    append(line_, column, row);
  }
  line_ += '\n';
  (void)std::fwrite(line_.data(), 1, line_.size(), stream_.get());
}

void TelemetryCsv::close() {
  if (!stream_) return;
  const bool failed = std::ferror(stream_.get()) != 0;
  errno = 0;
  if (std::fclose(stream_.release()) != 0 || failed) refuse(file_, errno);
}

}  // namespace sextant
