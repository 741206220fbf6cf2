#include "sextant/sim/mil_runner.hpp"

#include <chrono>

#include "progress_ticker.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/sim/metrics.hpp"
#include "sextant/sim/scenario_commands.hpp"
#include "sextant/sim/trace_recorder.hpp"

namespace sextant {
namespace {

/// Keeps the telemetry of the last period.
struct LastTelemetry {
  Telemetry<double> value{};
  void push(const Telemetry<double>& t) noexcept SEXTANT_NONBLOCKING { value = t; }
};

/// The plant's true state, each quantity computed once.
struct PlantLook {
  explicit PlantLook(const DrivePlant<double>& plant) noexcept
      : psi_s{plant.psi_s()},
        psi_r{plant.psi_r()},
        i_s{plant.machine().stator_current(psi_s, psi_r)},
        i_r{plant.machine().rotor_current(psi_s, psi_r)},
        torque{plant.machine().torque(psi_s, i_s)},
        omega_m{plant.omega_m()} {}

  SpaceVector<> psi_s, psi_r, i_s, i_r;
  double torque, omega_m;
};

PlantSample sample_plant(const PlantLook& plant, const SimulatedDriveIo<>& io) {
  return {
      plant.torque, io.tau_l(), plant.psi_s, plant.psi_r, inverse_clarke(plant.i_s), io.plant().inputs().u_dc,
      plant.omega_m};
}

MetricsSample sample_metrics(const Telemetry<double>& now, const ScenarioCommands& commands,
                             const PlantLook& plant, const InductionMachineParameters<>& machine) {
  return {
      .t_ns = now.t_ns,
      .torque_reference = commands.reference(now.t_ns),
      .torque = plant.torque,
      .psi_s = plant.psi_s,
      .i_s = plant.i_s,
      .omega_m = plant.omega_m,
      .switch_state = now.switch_state,
      .p_dc = now.u_dc * now.i_dc,
      .p_copper = 1.5 * (machine.r_s * dot(plant.i_s, plant.i_s) + machine.r_r * dot(plant.i_r, plant.i_r)),
      .speed_reference = commands.speed_reference(now.t_ns)};
}

void note_faults(MilResult& result, const Telemetry<double>& now) {
  if (now.latched.any() && !result.faults.any()) {
    result.first_fault = now.first_fault;
    result.fault_ns = now.t_ns;
  }
  result.faults |= now.latched;
}

}  // namespace

MilResult MilRunner::run(const Scenario& scenario, TraceRecorder* trace, const Progress& progress) {
  ScenarioCommands commands{scenario};
  MetricsAccumulator metrics{scenario.metrics};
  LastTelemetry telemetry;
  ProgressTicker ticker{progress, 1024};
  MilResult result;
  const auto begin = std::chrono::steady_clock::now();

  std::int64_t simulated_ns = 0;
  std::int64_t t_ns = -std::int64_t{ScenarioCommands::hand_shake_periods} * period_ns_;
  for (; t_ns <= scenario.duration_ns && io_.healthy(); t_ns += period_ns_) {
    run_cycle(t_ns, io_, commands, drive_, telemetry);
    const Telemetry<double>& now = telemetry.value;
    note_faults(result, now);
    commands.note_speed(now.omega_m);
    if (t_ns < 0) continue;
    simulated_ns = t_ns;
    const PlantLook plant{io_.plant()};
    metrics.add(sample_metrics(now, commands, plant, io_.plant().machine().parameters()));
    if (trace != nullptr) trace->add(now, sample_plant(plant, io_));
    if (!ticker.tick(double(t_ns) / double(scenario.duration_ns))) break;
  }

  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  result.metrics = metrics.metrics();
  result.metrics[Metric::simulated] = double(simulated_ns) * 1e-9;
  result.metrics[Metric::wall] = wall.count();
  result.metrics[Metric::realtime_factor] = result.metrics[Metric::simulated] / wall.count();
  result.plant_healthy = io_.healthy();
  result.final_state = drive_.state();
  return result;
}

}  // namespace sextant
