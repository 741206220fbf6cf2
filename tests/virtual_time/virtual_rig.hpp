#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "ecu/unit/drive_unit.hpp"
#include "ecu/virtual_time/virtual_ecu.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/virtual_time/disturbed_drive_io.hpp"
#include "sextant/virtual_time/log_replay.hpp"
#include "sextant/virtual_time/random_bus_events.hpp"
#include "sextant/virtual_time/virtual_vehicle.hpp"
#include "support/source_directory.hpp"

namespace sextant::test {

inline constexpr std::int64_t ms = 1'000'000;  // [ns]

/// The drive that is shipped, configs/ecu.toml.
inline const DriveConfig& shipped_drive() {
  static const DriveConfig config = load_ecu_config(SEXTANT_SOURCE_DIR "/configs/ecu.toml").drive;
  return config;
}

/// Parameters of its direct torque control.
inline DirectTorqueController<>::Parameters& direct_torque(DriveConfig& config) {
  for (auto& method : config.methods) {
    if (method->name() == std::string_view{DirectTorqueController<>::name})
      return method->parameters<DirectTorqueController<>>();
  }
  throw std::logic_error("no direct torque control");
}

/// What a rig is made of.
struct VirtualRigParameters {
  double torque{15.0};          ///< that the vehicle asks for [N·m]
  double omega_m{40.0};         ///< imposed on the shaft [rad/s]
  int wake_every_periods{1};    ///< [-]
  std::vector<BusEvent> bus{};  ///< what happens on the bus
  std::vector<LateWake> late_wakes{};
  VirtualVehicle::Parameters vehicle{};
  std::int64_t vehicle_duration_ns{never_ns};
  DriveConfig config{
      shipped_drive()};  ///< its plant is integrated in fixed steps, with sensors and fault below
  std::optional<ProfileParameters> speed{};  ///< imposed, in the place of omega_m [rad/s]
  SensorParameters sensors{};
  PlantFaultParameters fault{};
  std::vector<MeasurementEvent> measurements{};  ///< what is wrong with the measurements
  std::vector<LoggedFrame> log{};                ///< played in the vehicle's place where there is one
  IdentifierOffset identifier_offset{};          ///< of the drive; the vehicle has its own
};

/// The whole live drive with its plant and a vehicle, in virtual time.
class VirtualRig {
 public:
  static constexpr std::int32_t period_ns = 25'000;  ///< of the shipped drive

  explicit VirtualRig(const VirtualRigParameters& p = {})
      : torque{p.torque},
        drive_parameters_{p.config.drive},
        stage_{stage_parameters(p),
               {.imposed_speed = p.speed.value_or(ProfileParameters{.value = p.omega_m})}},
        io{stage_.io(), p.measurements},
        bus{clock, p.bus},
        unit_{ecu_config(p), io, bus},
        replay{p.log, bus, {p.identifier_offset}},
        vehicle{p.vehicle, clock, bus, [this](std::int64_t) { return torque; }, p.vehicle_duration_ns},
        recorder{40, {.period = [this](const Telemetry<double>& t) { see(t); }}},
        ecu_{{{.unit = unit_, .recorder = recorder, .late_wakes = LateWakes{p.late_wakes}}}, clock, bus} {
    timeline.add(bus.party());
    timeline.add(p.log.empty() ? vehicle.party() : replay.party());
    ecu_.join(timeline);
  }

  void run_until(std::int64_t t_ns) { timeline.run_until(t_ns); }
  void run_for(std::int64_t duration_ns) { run_until(clock.now_ns() + duration_ns); }

  /// Through the hand-shake until the drive has produced torque for 50 ms; false when it does not.
  [[nodiscard]] bool start() {
    run_until(200 * ms);
    return makes_torque(now().state);
  }

  [[nodiscard]] const Telemetry<double>& now() const noexcept { return ecu.telemetry(); }
  [[nodiscard]] DrivePlant<double> plant() { return stage_.io().plant(); }
  [[nodiscard]] const Drive<>::Parameters& drive_parameters() const noexcept { return drive_parameters_; }
  /// Forgets when what happened first.
  void forget() { first_fault_ns = first_zero_ns = never_ns; }

  double torque;                          ///< that the vehicle asks for [N·m]
  std::int64_t first_fault_ns{never_ns};  ///< the first period in FAULT [ns]
  std::int64_t first_zero_ns{never_ns};   ///< the first period without admitted torque [ns]
  std::function<void(const Telemetry<double>&)> on_period{};

 private:
  [[nodiscard]] static SimulatedPowerStage::Parameters stage_parameters(const VirtualRigParameters& p) {
    SimulatedPowerStage::Parameters stage = p.config.plant;
    stage.integrator = IntegratorKind::fixed;
    stage.io.sensors = p.sensors;
    stage.io.fault = p.fault;
    return stage;
  }

  [[nodiscard]] static EcuConfig ecu_config(const VirtualRigParameters& p) {
    return {.drive = p.config,
            .realtime = {.wake_every_periods = p.wake_every_periods},
            .can = {.identifier_offset = p.identifier_offset}};
  }

  void see(const Telemetry<double>& t) {
    if (t.state == DriveState::fault && first_fault_ns == never_ns) first_fault_ns = t.t_ns;
    if (t.torque_reference == 0.0 && first_zero_ns == never_ns) first_zero_ns = t.t_ns;
    if (on_period) on_period(t);
  }

  Drive<>::Parameters drive_parameters_;
  SimulatedPowerStage stage_;

 public:
  VirtualClock clock{};
  DisturbedDriveIo io;
  VirtualCanBus bus;

 private:
  ecu::DriveUnit unit_;

 public:
  LogReplay replay;
  VirtualVehicle vehicle;
  RunRecorder recorder;

 private:
  ecu::VirtualEcu ecu_;

 public:
  ecu::VirtualUnit& ecu{ecu_.drive(0)};
  VirtualTimeline timeline{clock};
};

}  // namespace sextant::test
