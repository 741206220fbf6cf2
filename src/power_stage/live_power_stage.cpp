#include "sextant/power_stage/live_power_stage.hpp"

#include <type_traits>

namespace sextant {
namespace {

/// A power stage of that type, and its own `DriveIo`.
template <class Stage>
std::shared_ptr<FaultableDriveIo> io_of(const SimulatedPowerStageParameters& parameters,
                                        const MechanicalLoad::Parameters& load) {
  const auto stage = std::make_shared<Stage>(parameters, load);
  return {stage, &stage->io()};
}

}  // namespace

LivePowerStage::LivePowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load)
    : io_{with_appended(parameters, [&]<class Appended>(std::type_identity<Appended>) {
        return parameters.thermal.acts() || parameters.losses.acts()
                   ? io_of<MeteredPowerStageOf<Appended>>(parameters, load)
                   : io_of<PowerStageOf<Appended>>(parameters, load);
      })} {}

}  // namespace sextant
