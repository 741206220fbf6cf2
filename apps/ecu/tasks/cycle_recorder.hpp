#pragma once

#include <cstddef>
#include <cstdint>

#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/cycle_record.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant::ecu {

/// Records every control period for a replay: it stands between the cycle and the power stage, SharedCommands
/// tells it the requests, and a ring takes the records. A full ring drops and counts.
class CycleRecorder final : public DriveIo<double> {
 public:
  /// The power stage is not owned and must outlive this object. room: of the ring [control periods].
  CycleRecorder(DriveIo<double>& io, std::size_t room) : io_{io}, records_{room} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    record_.t_ns = t_ns;
    record_.measurement = io_.read(t_ns);
    return record_.measurement;
  }

  void note(const DriveRequest<double>& request) noexcept SEXTANT_NONBLOCKING { record_.request = request; }

  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    io_.write(pattern);
    record_.pattern = pattern;
    records_.push(record_);
  }

  /// For one reader.
  [[nodiscard]] Ring<CycleRecord<double>>& records() noexcept { return records_; }
  /// Control periods that the ring had no room for. [-]
  [[nodiscard]] std::uint64_t dropped() const noexcept { return records_.dropped(); }

 private:
  DriveIo<double>& io_;
  CycleRecord<double> record_{};
  Ring<CycleRecord<double>> records_;
};

}  // namespace sextant::ecu
