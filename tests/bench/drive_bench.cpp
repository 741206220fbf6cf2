#include <memory>

#include <benchmark/benchmark.h>

#include "bench/paired.hpp"
#include "bench/recorded_run.hpp"
#include "bench/reference_dtc.hpp"
#include "bench/reference_rk4.hpp"

namespace sextant::bench {
namespace {

const RecordedRun run = record_run();

/// Makes the compiler believe that the object is used, without copying it as DoNotOptimize would.
template <class Object>
void keep(const Object& object) {
  benchmark::DoNotOptimize(&object);
  benchmark::ClobberMemory();
}

void dtc_step_reference(benchmark::State& state) {
  ReferenceDtc dtc;
  std::size_t k = 0;
  for (auto _ : state) {
    const Measurement<double>& m = run.measurements[k];
    const GateSegment& acted = m.acted.segments()[0];
    benchmark::DoNotOptimize(dtc.step(m.i_abc.a, m.i_abc.b, m.i_abc.c, m.u_dc,
                                      int(acted.state.upper_switches()), acted.duration_ns,
                                      torque_reference));
    if (++k == run.measurements.size()) {
      k = 0;
      dtc.reset();
    }
  }
}
BENCHMARK(dtc_step_reference);

void dtc_step(benchmark::State& state) {
  const std::unique_ptr<Controller<double>> controller =
      std::make_unique<DirectTorqueController<double>>(DirectTorqueController<double>::Parameters{});
  const ControlReference<double> reference{ControlMode::torque, torque_reference};
  std::size_t k = 0;
  for (auto _ : state) {
    const GatePattern pattern = controller->step(run.measurements[k], reference);
    keep(pattern);
    if (++k == run.measurements.size()) {
      k = 0;
      controller->reset();  // the flux estimate is an integral: a replay must not drift
    }
  }
}
BENCHMARK(dtc_step);

void drive_step(benchmark::State& state) {
  DirectTorqueController<double> controller{{}};
  Drive<double> drive{{}, controller};
  ScenarioCommands commands{ProfileParameters{.value = torque_reference}};
  std::int64_t t_ns = -ScenarioCommands::hand_shake_periods * 25'000;
  std::size_t k = 0;
  for (auto _ : state) {
    Measurement<double> m = run.measurements[k];
    m.t_ns = t_ns;
    const DriveOutput<double> output = drive.step(m, commands.latest(t_ns));
    keep(output);
    t_ns += 25'000;
    k = k + 1 == run.measurements.size() ? 0 : k + 1;
  }
}
BENCHMARK(drive_step);

void plant_rk4_reference(benchmark::State& state) {
  ReferenceRk4 plant;
  std::size_t k = 0;
  for (auto _ : state) {
    const SpaceVector<> u = stator_voltage(run.patterns[k].last_state(), 530.0);
    plant.step(u.alpha, u.beta, 15.0, 25e-6);
    keep(plant);
    k = k + 1 == run.patterns.size() ? 0 : k + 1;
  }
}
BENCHMARK(plant_rk4_reference);

void plant_period(benchmark::State& state, IntegratorKind kind) {
  using Plant = DrivePlant<double>;
  Plant plant{{}};
  std::unique_ptr<PlantIntegrator<Plant>> integrator = std::make_unique<FixedStepIntegrator<Plant>>();
  if (kind == IntegratorKind::cvode) integrator = std::make_unique<CvodeIntegrator<Plant>>();
  std::size_t k = 0;
  for (auto _ : state) {
    plant.set_inputs({run.patterns[k].last_state(), 530.0, 15.0, false, 0.0});
    if (!integrator->advance(plant, 25'000)) state.SkipWithError("the integration failed");
    k = k + 1 == run.patterns.size() ? 0 : k + 1;
  }
}
BENCHMARK_CAPTURE(plant_period, fixed, IntegratorKind::fixed);
BENCHMARK_CAPTURE(plant_period, cvode, IntegratorKind::cvode);

/// Counter `ratio`: the DTC step to its hand-written reference, one replay of the recorded run a block.
void dtc_step_ratio(benchmark::State& state) {
  ReferenceDtc reference;
  const std::unique_ptr<Controller<double>> controller =
      std::make_unique<DirectTorqueController<double>>(DirectTorqueController<double>::Parameters{});
  const ControlReference<double> wanted{ControlMode::torque, torque_reference};
  const auto by_hand = [&] {
    reference.reset();
    for (const Measurement<double>& m : run.measurements) {
      const GateSegment& acted = m.acted.segments()[0];
      benchmark::DoNotOptimize(reference.step(m.i_abc.a, m.i_abc.b, m.i_abc.c, m.u_dc,
                                              int(acted.state.upper_switches()), acted.duration_ns,
                                              torque_reference));
    }
  };
  const auto ours = [&] {
    controller->reset();
    for (const Measurement<double>& m : run.measurements) {
      const GatePattern pattern = controller->step(m, wanted);
      keep(pattern);
    }
  };
  for (auto _ : state) state.counters["ratio"] = paired_ratio(by_hand, ours);
}
BENCHMARK(dtc_step_ratio)->Iterations(1)->Unit(benchmark::kMillisecond);

/// Counter `ratio`: a fixed-step period of the plant to a hand-written Runge-Kutta step of the same
/// equations.
void plant_period_ratio(benchmark::State& state) {
  using Plant = DrivePlant<double>;
  ReferenceRk4 reference;
  Plant plant{{}};
  const std::unique_ptr<PlantIntegrator<Plant>> integrator = std::make_unique<FixedStepIntegrator<Plant>>();
  const auto by_hand = [&] {
    for (const GatePattern& pattern : run.patterns) {
      const SpaceVector<> u = stator_voltage(pattern.last_state(), 530.0);
      reference.step(u.alpha, u.beta, torque_reference, 25e-6);
      keep(reference);
    }
  };
  bool good = true;
  const auto ours = [&] {
    for (const GatePattern& pattern : run.patterns) {
      plant.set_inputs({pattern.last_state(), 530.0, torque_reference, false, 0.0});
      good = integrator->advance(plant, 25'000) && good;
    }
  };
  for (auto _ : state) state.counters["ratio"] = paired_ratio(by_hand, ours, 1000);
  if (!good) state.SkipWithError("the integration failed");
}
BENCHMARK(plant_period_ratio)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sextant::bench
