#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "sextant/core/telemetry_interval.hpp"

namespace sextant {

/// Writes telemetry as CSV: the members of `TelemetryIntervalRecord` as columns under their names, one record
/// a line, each number with the fewest digits that read back as the same number, the state by its name. The
/// same records make the same bytes.
class TelemetryCsv {
 public:
  /// Replaces a file of that name. Throws std::runtime_error with file and reason.
  explicit TelemetryCsv(std::string file);

  /// After an error of writing this does nothing.
  void add(const TelemetryIntervalRecord<double>& record);

  /// Closes the file. Throws std::runtime_error where something could not be written.
  void close();

 private:
  struct Close {
    void operator()(std::FILE* f) const noexcept { std::fclose(f); }
  };
  std::string file_;
  std::unique_ptr<std::FILE, Close> stream_;
  std::string line_{};
};

}  // namespace sextant
