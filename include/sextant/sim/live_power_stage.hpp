#pragma once

#include <memory>
#include <type_traits>
#include <utility>

#include "sextant/core/drive_io.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant {

/// The power stage of a live drive, with the link and the driveline that its parameters ask for, and with an
/// energy meter where a thermal network is heated by the losses.
class LivePowerStage {
 public:
  using Parameters = SimulatedPowerStageParameters;

  /// Throws as the power stages do.
  LivePowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load) {
    with_appended(parameters, [&]<class Appended>(std::type_identity<Appended>) {
      parameters.thermal.acts() ? make<MeteredPowerStageOf<Appended>>(parameters, load)
                                : make<PowerStageOf<Appended>>(parameters, load);
    });
  }

  [[nodiscard]] DriveIo<double>& io() noexcept { return *io_; }

 private:
  template <class Stage>
  void make(const Parameters& parameters, const MechanicalLoad::Parameters& load) {
    auto stage = std::make_shared<Stage>(parameters, load);
    io_ = &stage->io();
    stage_ = std::move(stage);
  }

  std::shared_ptr<void> stage_{};  ///< owns the power stage, whose type the parameters decide
  DriveIo<double>* io_{nullptr};   ///< its own
};

}  // namespace sextant
