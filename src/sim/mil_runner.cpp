#include "sextant/sim/mil_runner.hpp"

#include <chrono>

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

/// Tells how far a run is, some twenty times a second.
class ProgressTicker {
 public:
  explicit ProgressTicker(const MilRunner::Progress& progress) : progress_{progress} {}

  /// False when the run shall stop.
  bool tick(double fraction) {
    if (!progress_ || (++calls_ & 1023U) != 0) return true;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds{50}) return true;
    last_ = now;
    return progress_(fraction);
  }

 private:
  const MilRunner::Progress& progress_;
  std::chrono::steady_clock::time_point last_{std::chrono::steady_clock::now()};
  std::uint32_t calls_{0};
};

PlantSample sample_plant(const SimulatedDriveIo<>& io) {
  const auto& plant = io.plant();
  return {plant.tau_e(), io.tau_l(),          plant.psi_s(),  plant.psi_r(),
          plant.i_abc(), plant.inputs().u_dc, plant.omega_m()};
}

MetricsSample sample_metrics(std::int64_t t_ns, double reference, const SimulatedDriveIo<>& io,
                             SwitchState state) {
  const auto& plant = io.plant();
  return {t_ns, reference, plant.tau_e(), plant.psi_s(), plant.i_s(), plant.omega_m(), state};
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
  ScenarioCommands commands{scenario.torque_reference};
  MetricsAccumulator metrics{scenario.metrics};
  LastTelemetry telemetry;
  ProgressTicker ticker{progress};
  MilResult result;
  const auto begin = std::chrono::steady_clock::now();

  std::int64_t simulated_ns = 0;
  std::int64_t t_ns = -std::int64_t{ScenarioCommands::hand_shake_periods} * period_ns_;
  for (; t_ns <= scenario.duration_ns && io_.healthy(); t_ns += period_ns_) {
    run_cycle(t_ns, io_, commands, drive_, telemetry);
    const Telemetry<double>& now = telemetry.value;
    note_faults(result, now);
    if (t_ns < 0) continue;
    simulated_ns = t_ns;
    metrics.add(sample_metrics(t_ns, commands.reference(t_ns), io_, now.switch_state));
    if (trace != nullptr) trace->add(now, sample_plant(io_));
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
