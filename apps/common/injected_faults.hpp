#pragma once

#include "sextant/core/drive_io.hpp"
#include "sextant/power_stage/faultable_drive_io.hpp"
#include "sextant/realtime/latest_value.hpp"

namespace sextant {

/// A simulated power stage with the faults that another thread gives it. It allocates, locks and waits no
/// more than the power stage does.
class InjectedFaults final : public DriveIo<double> {
 public:
  /// The power stage is not owned and must outlive this object.
  explicit InjectedFaults(FaultableDriveIo& io) noexcept : io_{io} {}

  /// By one other thread: the fault from the next control period on. Of two within a period the later one
  /// counts.
  void store(const PlantFaultParameters& fault) noexcept { newest_.store(fault); }

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    if (newest_.update()) [[unlikely]]
      io_.inject(newest_.value());
    return io_.read(t_ns);
  }
  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override { io_.write(pattern); }

 private:
  FaultableDriveIo& io_;
  LatestValue<PlantFaultParameters> newest_{};
};

}  // namespace sextant
