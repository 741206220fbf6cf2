#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/paired.hpp"
#include "bench/recorded_run.hpp"
#include "bench/reference_rk4.hpp"

namespace sextant::bench {
namespace {

using Plant = DrivePlant<double>;

const RecordedRun run = record_run();
const std::vector<GatePattern>& patterns = run.patterns;

/// Makes the compiler believe that the object is used, without copying it as DoNotOptimize would.
template <class Object>
void keep(const Object& object) {
  benchmark::DoNotOptimize(&object);
  benchmark::ClobberMemory();
}

std::unique_ptr<PlantIntegrator<Plant>> make(IntegratorKind kind) {
  SimulatedPowerStage::Parameters parameters;
  parameters.integrator = kind;
  return SimulatedPowerStage::make_integrator(parameters);
}

constexpr std::int64_t period_ns = 25'000;

/// What the shaft does: follow the torques, or turn at a constant speed.
enum class Shaft : std::uint8_t { free, held };

PlantInputs<double> inputs(const GatePattern& pattern, Shaft shaft) {
  return {pattern.last_state(), 530.0, torque_reference, shaft == Shaft::held, 0.0};
}

void plant_rk4_reference(benchmark::State& state) {
  ReferenceRk4 plant;
  std::size_t k = 0;
  for (auto _ : state) {
    if (k == 0) plant.set_state(run.begin);
    const SpaceVector<> u = stator_voltage(patterns[k].last_state(), 530.0);
    plant.step(u.alpha, u.beta, torque_reference, 25e-6);
    keep(plant);
    k = k + 1 == patterns.size() ? 0 : k + 1;
  }
}
BENCHMARK(plant_rk4_reference);

void plant_period(benchmark::State& state, IntegratorKind kind, Shaft shaft) {
  Plant plant{{}};
  const auto integrator = make(kind);
  std::size_t k = 0;
  for (auto _ : state) {
    if (k == 0) plant.set_state(run.begin);
    plant.set_inputs(inputs(patterns[k], shaft));
    if (!integrator->advance(plant, period_ns)) state.SkipWithError("the integration failed");
    k = k + 1 == patterns.size() ? 0 : k + 1;
  }
}
BENCHMARK_CAPTURE(plant_period, fixed, IntegratorKind::fixed, Shaft::free);
BENCHMARK_CAPTURE(plant_period, exact, IntegratorKind::exact, Shaft::free);
BENCHMARK_CAPTURE(plant_period, exact_at_constant_speed, IntegratorKind::exact, Shaft::held);
BENCHMARK_CAPTURE(plant_period, erk, IntegratorKind::erk, Shaft::free);
BENCHMARK_CAPTURE(plant_period, cvode, IntegratorKind::cvode, Shaft::free);

/// Counter `ratio`: a period of the plant to a hand-written Runge-Kutta step of the same equations, one
/// replay of the recorded run a block. Each replay begins where the record does: patterns that do not meet
/// their machine drive it to a speed at which the integrator takes more steps.
void plant_period_ratio(benchmark::State& state, IntegratorKind kind, Shaft shaft) {
  ReferenceRk4 reference;
  Plant plant{{}};
  const auto integrator = make(kind);
  const auto by_hand = [&] {
    reference.set_state(run.begin);
    for (const GatePattern& pattern : patterns) {
      const SpaceVector<> u = stator_voltage(pattern.last_state(), 530.0);
      reference.step(u.alpha, u.beta, torque_reference, 25e-6);
      keep(reference);
    }
  };
  bool good = true;
  const auto ours = [&] {
    plant.set_state(run.begin);
    for (const GatePattern& pattern : patterns) {
      plant.set_inputs(inputs(pattern, shaft));
      good = integrator->advance(plant, period_ns) && good;
    }
  };
  for (auto _ : state) state.counters["ratio"] = paired_ratio(by_hand, ours, 1000);
  if (!good) state.SkipWithError("the integration failed");
}
void fixed_ratio(benchmark::State& state) {
  plant_period_ratio(state, IntegratorKind::fixed, Shaft::free);
}
BENCHMARK(fixed_ratio)->Name("plant_period_ratio")->Iterations(1)->Unit(benchmark::kMillisecond);

#define SEXTANT_PLANT_RATIO(name, kind, shaft)                             \
  BENCHMARK_CAPTURE(plant_period_ratio, name, IntegratorKind::kind, shaft) \
      ->Iterations(1)                                                      \
      ->Unit(benchmark::kMillisecond)
SEXTANT_PLANT_RATIO(exact, exact, Shaft::free);
SEXTANT_PLANT_RATIO(exact_at_constant_speed, exact, Shaft::held);
SEXTANT_PLANT_RATIO(erk, erk, Shaft::free);
SEXTANT_PLANT_RATIO(cvode, cvode, Shaft::free);
#undef SEXTANT_PLANT_RATIO

}  // namespace
}  // namespace sextant::bench
