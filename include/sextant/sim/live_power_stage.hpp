#pragma once

#include <memory>

#include "sextant/core/drive_io.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant {

/// The power stage of a live drive, with the link that its parameters ask for: stiff, or with a voltage that
/// is a state.
class LivePowerStage {
 public:
  using Parameters = SimulatedPowerStageParameters;

  /// Throws as the power stages do.
  LivePowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load) {
    if (parameters.link.acts())
      linked_ = std::make_unique<LinkedPowerStage>(parameters, load);
    else
      stiff_ = std::make_unique<SimulatedPowerStage>(parameters, load);
  }

  [[nodiscard]] DriveIo<double>& io() noexcept {
    if (linked_) return linked_->io();
    return stiff_->io();
  }

 private:
  std::unique_ptr<SimulatedPowerStage> stiff_{};
  std::unique_ptr<LinkedPowerStage> linked_{};
};

}  // namespace sextant
