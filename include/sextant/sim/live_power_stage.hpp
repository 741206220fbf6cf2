#pragma once

#include <memory>
#include <utility>

#include "sextant/core/drive_io.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant {

/// The power stage of a live drive, with the plant that its parameters ask for: with a stiff link or one
/// whose voltage is a state, and with an energy meter where a thermal network is heated by the losses.
class LivePowerStage {
 public:
  using Parameters = SimulatedPowerStageParameters;

  /// Throws as the power stages do.
  LivePowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load) {
    const bool heats = parameters.thermal.acts();
    if (parameters.link.acts())
      heats ? make<LinkedMeteredPowerStage>(parameters, load) : make<LinkedPowerStage>(parameters, load);
    else
      heats ? make<MeteredPowerStage>(parameters, load) : make<SimulatedPowerStage>(parameters, load);
  }

  [[nodiscard]] DriveIo<double>& io() noexcept { return *io_; }

 private:
  template <class Stage>
  void make(const Parameters& parameters, const MechanicalLoad::Parameters& load) {
    auto stage = std::make_shared<Stage>(parameters, load);
    io_ = &stage->io();
    stage_ = std::move(stage);
  }

  std::shared_ptr<void> stage_{};
  DriveIo<double>* io_{};
};

}  // namespace sextant
