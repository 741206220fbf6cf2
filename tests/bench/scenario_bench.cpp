#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/event_exact/event_exact_runner.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "sextant/run/mil_runner.hpp"
#include "support/source_directory.hpp"

namespace sextant::bench {
namespace {

MilResult run(const ScenarioConfig& config, TraceRecorder* trace) {
  if (config.mode == ScenarioMode::event_exact) {
    return EventExactRunner{config.event_exact_runner()}.run(config.scenario, trace, {});
  }
  MeteredPowerStage power_stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  return MilRunner{drive, power_stage.io(), config.drive.drive.period_ns}.run(config.scenario, trace, {});
}

enum class Trace { none, written };

/// A scenario from its file, with metrics. Counter: simulated time per CPU time.
void scenario(benchmark::State& state, const char* file, const std::vector<std::string>& overrides,
              Trace traced) {
  const std::string directory = std::string{SEXTANT_SOURCE_DIR} + "/configs/scenarios/";
  const ScenarioConfig config = load_scenario_config(directory + file, overrides);
  const std::filesystem::path trace_file =
      std::filesystem::temp_directory_path() / ("sextant_bench_" + std::to_string(getpid()) + ".h5");
  double simulated_s = 0.0;
  for (auto _ : state) {
    std::optional<TraceRecorder> trace;
    if (traced == Trace::written) {
      const bool sampled = config.mode == ScenarioMode::sampled;
      trace.emplace(
          trace_file, config.scenario.trace,
          TraceOrigin{config.scenario.name,
                      sampled ? std::optional<std::int64_t>{config.drive.drive.period_ns} : std::nullopt});
    }
    const MilResult result = run(config, trace ? &*trace : nullptr);
    if (trace) trace->close();
    if (!result.plant_healthy) state.SkipWithError("the integration failed");
    simulated_s += result.metrics[Metric::simulated];
  }
  std::filesystem::remove(trace_file);
  state.counters["realtime_factor"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
}

const std::vector<std::string> on_cvode{"plant.integrator=cvode"};
const std::vector<std::string> fixed_step{"plant.integrator=fixed"};
const std::vector<std::string> on_cvode_1e_8{"plant.integrator=cvode", "plant.cvode.relative_tolerance=1e-8",
                                             "plant.cvode.flux_tolerance_wb=1e-10"};
const std::vector<std::string> sampled{"mode=sampled", "plant.integrator=fixed"};

BENCHMARK_CAPTURE(scenario, sampled_3_1_cvode, "constant_torque.toml", on_cvode, Trace::none)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scenario, sampled_3_1_fixed, "constant_torque.toml", fixed_step, Trace::none)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scenario, sampled_nycc_traced, "paper/3_5_nycc_linear.toml", sampled, Trace::written)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->Repetitions(3);

#define SEXTANT_EVENT_EXACT(name, file)                                                        \
  BENCHMARK_CAPTURE(scenario, exact_##name##_fixed, "paper/" file, fixed_step, Trace::written) \
      ->Unit(benchmark::kMillisecond)                                                          \
      ->Iterations(1)                                                                          \
      ->Repetitions(3)
#define SEXTANT_EVENT_EXACT_BOTH(name, file)                                                   \
  SEXTANT_EVENT_EXACT(name, file);                                                             \
  BENCHMARK_CAPTURE(scenario, exact_##name##_cvode, "paper/" file, on_cvode_1e_8, Trace::none) \
      ->Unit(benchmark::kMillisecond)                                                          \
      ->Iterations(1)                                                                          \
      ->Repetitions(3)

SEXTANT_EVENT_EXACT_BOTH(3_1, "3_1_constant_torque.toml");
SEXTANT_EVENT_EXACT_BOTH(3_2, "3_2_reversal.toml");
SEXTANT_EVENT_EXACT_BOTH(3_3, "3_3_smooth.toml");
SEXTANT_EVENT_EXACT_BOTH(3_4, "3_4_high_torque.toml");
SEXTANT_EVENT_EXACT(nycc, "3_5_nycc_linear.toml");
SEXTANT_EVENT_EXACT(table6, "table6.toml");

#undef SEXTANT_EVENT_EXACT_BOTH
#undef SEXTANT_EVENT_EXACT

}  // namespace
}  // namespace sextant::bench
