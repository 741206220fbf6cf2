#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "ecu/shared/cycle_recorder.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/recording/cycle_file.hpp"

namespace sextant::ecu {

/// The recording of a run's control periods for a replay: a recorder in the probe of the periods, and the
/// file that takes what the recorder has.
class CycleLog {
 public:
  CycleLog(const std::string& file, const EcuConfig& config);

  /// Makes the file; before the first control period. Throws std::runtime_error with one sentence where that
  /// cannot be.
  void open();

  [[nodiscard]] CycleRecorder& recorder() noexcept { return recorder_; }

  /// Writes what has come. After a failure nothing more is written, and the drive runs on.
  void poll();
  /// Once no control period can come: writes the rest.
  void close();
  /// Why the recording has ended before its end, in one sentence; empty where it has not.
  [[nodiscard]] const std::string& failure() const noexcept { return failure_; }

  /// For people.
  void print_report(std::FILE* out) const;

 private:
  static constexpr std::size_t most_at_once = 4096;  // [control periods]

  void write_waiting();
  template <class Write>
  void guarded(Write&& write);

  std::string file_;
  std::string configuration_;
  CycleRecorder recorder_;
  std::unique_ptr<CycleFileWriter> writer_{};  // once the file is open
  std::vector<CycleRecord<double>> waiting_{};
  std::string failure_{};
};

}  // namespace sextant::ecu
