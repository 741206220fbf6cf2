#pragma once

#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/cycle_record.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant::ecu {

/// Records every control period for a replay, as a part of the probe of `run_cycle`; a ring takes the
/// records. A full ring drops and counts.
class CycleRecorder {
 public:
  /// room: of the ring [control periods].
  explicit CycleRecorder(std::size_t room) : records_{room} {}

  void begins(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING { record_.t_ns = t_ns; }
  void has_read(const Measurement<double>& measurement) noexcept SEXTANT_NONBLOCKING {
    record_.measurement = measurement;
  }
  void has_request(const DriveRequest<double>& request) noexcept SEXTANT_NONBLOCKING {
    record_.request = request;
  }
  void has_stepped(const DriveOutput<double>& output) noexcept SEXTANT_NONBLOCKING {
    record_.pattern = output.pattern;
  }
  void has_written() noexcept SEXTANT_NONBLOCKING { records_.push(record_); }

  /// For one reader.
  [[nodiscard]] Ring<CycleRecord<double>>& records() noexcept { return records_; }
  /// Control periods that the ring had no room for. [-]
  [[nodiscard]] std::uint64_t dropped() const noexcept { return records_.dropped(); }

 private:
  CycleRecord<double> record_{};
  Ring<CycleRecord<double>> records_;
};

}  // namespace sextant::ecu
