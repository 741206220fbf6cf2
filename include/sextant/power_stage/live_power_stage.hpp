#pragma once

#include <memory>

#include "sextant/power_stage/faultable_drive_io.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {

/// The power stage of a live drive, with the link and the driveline that its parameters ask for, and with an
/// energy meter where a thermal network is heated by the losses, or the inverter has some.
class LivePowerStage {
 public:
  using Parameters = SimulatedPowerStageParameters;

  /// Throws as the power stages do.
  LivePowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load);

  [[nodiscard]] FaultableDriveIo& io() noexcept { return *io_; }

 private:
  std::shared_ptr<FaultableDriveIo> io_;  ///< owns the power stage, whose type the parameters decide
};

}  // namespace sextant
