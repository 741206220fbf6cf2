// Everything that runs on the control thread, instantiated, so that clang's -Wfunction-effects walks through
// it. Checked by scripts/check_function_effects; GCC compiles it as well, so that it stays valid.
#include "sextant/config/control_methods.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/drive/cycle_record.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/hil/plant_server.hpp"
#include "sextant/hil/shared_memory_drive_io.hpp"
#include "sextant/hil/shared_memory_plant_end.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/dc_link.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/driveline.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/power_stage/segment_log.hpp"
#include "sextant/power_stage/simulated_drive_io.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/latest_value.hpp"
#include "sextant/realtime/ring.hpp"
#include "sextant/realtime/wake_schedule.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {

template class Drive<double>;
template class Drive<float>;
template class TelemetryInterval<double>;
template class TelemetryInterval<float>;
template class LatestValue<DriveRequest<double>>;
template class Ring<Telemetry<double>>;
template class Ring<CycleRecord<double>>;
template class FixedStepIntegrator<DrivePlant<double>>;
template class FixedStepIntegrator<DrivePlant<float>>;
template class ExactIntegrator<DrivePlant<double>>;
template class ExactIntegrator<DrivePlant<float>>;
template class SimulatedDriveIo<DrivePlant<double>>;
template class FixedStepIntegrator<DrivePlant<double, DcLink<double>>>;
template class ExactIntegrator<DrivePlant<double, DcLink<double>>>;
template class SimulatedDriveIo<DrivePlant<double, DcLink<double>>>;
template class FixedStepIntegrator<DrivePlant<double, AppendedPair<DcLink<double>, EnergyMeter<double>>>>;
template class FixedStepIntegrator<DrivePlant<double, Driveline<double>>>;
template class ExactIntegrator<DrivePlant<double, Driveline<double>>>;
template class SimulatedDriveIo<DrivePlant<double, Driveline<double>>>;
template class FixedStepIntegrator<DrivePlant<double, AppendedPair<DcLink<double>, Driveline<double>>>>;
template class SimulatedDriveIo<DrivePlant<double, AppendedPair<DcLink<double>, Driveline<double>>>>;
template class FixedStepIntegrator<DrivePlant<double, EnergyMeter<double>>>;
template class ExactIntegrator<DrivePlant<double, EnergyMeter<double>>>;
template class SimulatedDriveIo<DrivePlant<double, EnergyMeter<double>>,
                                SegmentLog<DrivePlant<double, EnergyMeter<double>>>>;
template class RecordRing<MeasurementRecord, LinkMemory::ring_capacity>;
template class SequenceCell<DrivePatternRecord>;

namespace {

template <class T>
class CommandCell {
 public:
  [[nodiscard]] DriveRequest<T> latest(std::int64_t) noexcept SEXTANT_NONBLOCKING { return cell_.latest(); }

 private:
  LatestValue<DriveRequest<T>> cell_{};
};

}  // namespace

// Every controller of the lists: that it can be made makes its virtual functions.
template <class... C>
void make_each(std::tuple<C...>* /*list*/) {
  (static_cast<void>(C{typename C::Parameters{}}), ...);
}
template void make_each(ControllerList<double>*);
template void make_each(ControllerList<float>*);
template void make_each(CommissioningList<double>*);
template void make_each(CommissioningList<float>*);

// Each is the whole of a control period.
void live_cycle(std::int64_t t_ns, DriveIo<double>& io, Drive<double>& drive, Ring<Telemetry<double>>& ring,
                LatencyHistogram& latency) noexcept SEXTANT_NONBLOCKING;
void live_cycle(std::int64_t t_ns, DriveIo<double>& io, Drive<double>& drive, Ring<Telemetry<double>>& ring,
                LatencyHistogram& latency) noexcept SEXTANT_NONBLOCKING {
  CommandCell<double> commands;
  run_cycle(t_ns, io, commands, drive, ring);
  latency.record(t_ns);
}

void embedded_cycle(std::int64_t t_ns, DriveIo<float>& io, Drive<float>& drive,
                    Ring<Telemetry<float>>& ring) noexcept SEXTANT_NONBLOCKING;
void embedded_cycle(std::int64_t t_ns, DriveIo<float>& io, Drive<float>& drive,
                    Ring<Telemetry<float>>& ring) noexcept SEXTANT_NONBLOCKING {
  CommandCell<float> commands;
  run_cycle(t_ns, io, commands, drive, ring);
}

void scenario_cycle(std::int64_t t_ns, SimulatedDriveIo<DrivePlant<double>>& io, ScenarioCommands& commands,
                    Drive<double>& drive, Ring<Telemetry<double>>& ring) noexcept SEXTANT_NONBLOCKING;
void scenario_cycle(std::int64_t t_ns, SimulatedDriveIo<DrivePlant<double>>& io, ScenarioCommands& commands,
                    Drive<double>& drive, Ring<Telemetry<double>>& ring) noexcept SEXTANT_NONBLOCKING {
  run_cycle(t_ns, io, commands, drive, ring);
}

void linked_cycle(std::int64_t t_ns, SharedMemoryDriveIo& io, Drive<double>& drive,
                  Ring<Telemetry<double>>& ring) noexcept SEXTANT_NONBLOCKING;
void linked_cycle(std::int64_t t_ns, SharedMemoryDriveIo& io, Drive<double>& drive,
                  Ring<Telemetry<double>>& ring) noexcept SEXTANT_NONBLOCKING {
  CommandCell<double> commands;
  run_cycle(t_ns, io, commands, drive, ring);
}

// The plant's period on the other side of a link.
void plant_cycle(std::int64_t t_ns, PlantServer<SharedMemoryPlantEnd>& server) noexcept SEXTANT_NONBLOCKING;
void plant_cycle(std::int64_t t_ns, PlantServer<SharedMemoryPlantEnd>& server) noexcept SEXTANT_NONBLOCKING {
  server.step(t_ns);
}

}  // namespace sextant
