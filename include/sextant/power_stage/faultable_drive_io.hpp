#pragma once

#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/power_stage/plant_fault.hpp"

namespace sextant {

/// A simulated power stage that can be given faults while it runs.
class FaultableDriveIo : public DriveIo<double> {
 public:
  /// Another fault in place of the one that is there, from the next read on; `none` ends it. Its times count
  /// from the plant's present time. Takes effect where the power stage was made with `takes_faults`. Called
  /// by the thread that reads.
  virtual void inject(const PlantFaultParameters& fault) noexcept SEXTANT_NONBLOCKING = 0;
};

}  // namespace sextant
