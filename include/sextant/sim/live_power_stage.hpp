#pragma once

#include <optional>

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
      linked_.emplace(parameters, load);
    else
      stiff_.emplace(parameters, load);
  }

  [[nodiscard]] DriveIo<double>& io() noexcept {
    if (linked_) return linked_->io();
    return stiff_->io();
  }

 private:
  std::optional<SimulatedPowerStage> stiff_{};
  std::optional<LinkedPowerStage> linked_{};
};

}  // namespace sextant
