#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "ecu/tasks/cycle_recorder.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/sim/cycle_file.hpp"

namespace sextant::ecu {

/// The recording of a run's control periods for a replay: a recorder before the power stage, and the file
/// that takes what the recorder has.
class CycleLog {
 public:
  /// Throws std::runtime_error with one sentence where the file cannot be made.
  CycleLog(const std::string& file, const EcuConfig& config, DriveIo<double>& io);

  [[nodiscard]] CycleRecorder& recorder() noexcept { return recorder_; }

  /// Writes what has come. After a failure nothing more is written, and the drive runs on. Returns the
  /// failure in one sentence, once; otherwise nothing.
  [[nodiscard]] std::string poll();
  /// Once no control period can come: writes the rest.
  void close();

  /// For people.
  void print_report(std::FILE* out) const;

 private:
  static constexpr std::size_t most_at_once = 4096;  // [control periods]

  void write_waiting();

  std::string file_;
  CycleRecorder recorder_;
  CycleFileWriter writer_;
  std::vector<CycleRecord<double>> waiting_{};
  std::string failure_{};
};

}  // namespace sextant::ecu
