#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {

template class BasicSimulatedPowerStage<PowerStageOf<NoAppendedSystem<double>>::Plant,
                                        NoSegmentLog<PowerStageOf<NoAppendedSystem<double>>::Plant>>;
template class SimulatedDriveIo<PowerStageOf<NoAppendedSystem<double>>::Plant,
                                NoSegmentLog<PowerStageOf<NoAppendedSystem<double>>::Plant>>;
template class BasicSimulatedPowerStage<Metered<NoAppendedSystem<double>>::Plant,
                                        SegmentLog<Metered<NoAppendedSystem<double>>::Plant>>;
template class SimulatedDriveIo<Metered<NoAppendedSystem<double>>::Plant,
                                SegmentLog<Metered<NoAppendedSystem<double>>::Plant>>;
template class BasicSimulatedPowerStage<PowerStageOf<DcLink<double>>::Plant,
                                        NoSegmentLog<PowerStageOf<DcLink<double>>::Plant>>;
template class SimulatedDriveIo<PowerStageOf<DcLink<double>>::Plant,
                                NoSegmentLog<PowerStageOf<DcLink<double>>::Plant>>;
template class BasicSimulatedPowerStage<Metered<DcLink<double>>::Plant,
                                        SegmentLog<Metered<DcLink<double>>::Plant>>;
template class SimulatedDriveIo<Metered<DcLink<double>>::Plant, SegmentLog<Metered<DcLink<double>>::Plant>>;
template class BasicSimulatedPowerStage<PowerStageOf<Driveline<double>>::Plant,
                                        NoSegmentLog<PowerStageOf<Driveline<double>>::Plant>>;
template class SimulatedDriveIo<PowerStageOf<Driveline<double>>::Plant,
                                NoSegmentLog<PowerStageOf<Driveline<double>>::Plant>>;
template class BasicSimulatedPowerStage<Metered<Driveline<double>>::Plant,
                                        SegmentLog<Metered<Driveline<double>>::Plant>>;
template class SimulatedDriveIo<Metered<Driveline<double>>::Plant,
                                SegmentLog<Metered<Driveline<double>>::Plant>>;
template class BasicSimulatedPowerStage<PowerStageOf<LinkAndDriveline>::Plant,
                                        NoSegmentLog<PowerStageOf<LinkAndDriveline>::Plant>>;
template class SimulatedDriveIo<PowerStageOf<LinkAndDriveline>::Plant,
                                NoSegmentLog<PowerStageOf<LinkAndDriveline>::Plant>>;
template class BasicSimulatedPowerStage<Metered<LinkAndDriveline>::Plant,
                                        SegmentLog<Metered<LinkAndDriveline>::Plant>>;
template class SimulatedDriveIo<Metered<LinkAndDriveline>::Plant,
                                SegmentLog<Metered<LinkAndDriveline>::Plant>>;

}  // namespace sextant
