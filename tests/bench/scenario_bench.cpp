#include <string>

#include <benchmark/benchmark.h>

#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/sim/mil_runner.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant::bench {
namespace {

/// Scenario 3.1 of the paper from its file, with metrics and without a trace. Counter: simulated per wall
/// time.
void scenario_3_1(benchmark::State& state, const char* integrator) {
  const ScenarioConfig config =
      load_scenario_config(std::string{SEXTANT_SOURCE_DIR} + "/configs/scenarios/constant_torque.toml",
                           {std::string{"plant.integrator="} + integrator});
  double simulated_s = 0.0;
  for (auto _ : state) {
    SimulatedPowerStage power_stage{config.drive.plant, config.scenario.load};
    const auto controller = make_controller(config.drive);
    Drive<double> drive{config.drive.drive, *controller};
    MilRunner runner{drive, power_stage.io(), config.drive.drive.period_ns};
    const MilResult result = runner.run(config.scenario, nullptr, {});
    if (!result.plant_healthy) state.SkipWithError("the integration failed");
    simulated_s += result.metrics[Metric::simulated];
  }
  state.counters["realtime_factor"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(scenario_3_1, cvode, "cvode")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scenario_3_1, fixed, "fixed")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sextant::bench
