#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/bench_drive.hpp"
#include "bench/drive_replay.hpp"
#include "bench/keep.hpp"
#include "bench/paired.hpp"
#include "bench/recorded_run.hpp"
#include "bench/reference_dtc.hpp"
#include "bench/reference_rk4.hpp"
#include "sextant/config/control_methods.hpp"
#include "sextant/control/flux_torque_estimator.hpp"

namespace sextant::bench {
namespace {

const RecordedRun run = record_run();

/// With the flux estimator of the hand-written reference.
std::unique_ptr<Controller<double>> papers_controller() {
  return std::make_unique<DirectTorqueController<double>>(
      DirectTorqueController<double>::Parameters{{.flux_estimator = FluxEstimatorKind::voltage_model}});
}

void dtc_step_reference(benchmark::State& state) {
  ReferenceDtc dtc;
  std::size_t k = 0;
  for (auto _ : state) {
    const Measurement<double>& m = run.measurements[k];
    const GateSegment& applied = m.applied.segments()[0];
    benchmark::DoNotOptimize(dtc.step(m.i_abc.a, m.i_abc.b, m.i_abc.c, m.u_dc,
                                      int(applied.state.upper_switches()), applied.duration_ns,
                                      torque_reference));
    if (++k == run.measurements.size()) {
      k = 0;
      dtc.reset();
    }
  }
}
BENCHMARK(dtc_step_reference);

void dtc_step(benchmark::State& state) {
  const std::unique_ptr<Controller<double>> controller = papers_controller();
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

/// A control method with its default parameters, on the measurements of its own drive.
template <class C>
void controller_step(benchmark::State& state) {
  const RecordedRun own = record_run<C>();
  C controller{{}};
  const ControlReference<double> reference{ControlMode::torque, torque_reference};
  std::size_t k = 0;
  for (auto _ : state) {
    const GatePattern pattern = controller.step(own.measurements[k], reference);
    keep(pattern);
    if (++k == own.measurements.size()) {
      k = 0;
      controller.reset();
    }
  }
}

template <class... C>
bool register_steps(std::tuple<C...>* /*list*/) {
  const auto add = [](const char* name, auto* step) {
    benchmark::RegisterBenchmark((std::string{"controller_step/"} + name).c_str(), step);
  };
  (add(C::name, &controller_step<C>), ...);
  return true;
}
const bool registered = register_steps(static_cast<ControllerList<double>*>(nullptr));

/// The flux and torque estimate alone, as each kind makes it.
void estimator_step(benchmark::State& state, FluxEstimatorKind kind) {
  const InductionMachineParameters<double> machine{};
  FluxTorqueEstimator<double> estimator{{.machine = machine, .kind = kind}};
  std::size_t k = 0;
  for (auto _ : state) {
    estimator.step(run.measurements[k]);
    keep(estimator);
    if (++k == run.measurements.size()) {
      k = 0;
      estimator.reset();
    }
  }
}
BENCHMARK_CAPTURE(estimator_step, voltage_model, FluxEstimatorKind::voltage_model);
BENCHMARK_CAPTURE(estimator_step, compensated_voltage_model, FluxEstimatorKind::compensated_voltage_model);
BENCHMARK_CAPTURE(estimator_step, current_model, FluxEstimatorKind::current_model);
BENCHMARK_CAPTURE(estimator_step, hybrid, FluxEstimatorKind::hybrid);
BENCHMARK_CAPTURE(estimator_step, observer, FluxEstimatorKind::observer);
BENCHMARK_CAPTURE(estimator_step, sensorless_observer, FluxEstimatorKind::sensorless_observer);

/// With the default estimator, every protection and the torque monitor.
void drive_step(benchmark::State& state) {
  DriveReplay<OurDrive> replay{run};
  for (auto _ : state) replay.next();
}
BENCHMARK(drive_step);

/// Counter `ratio`: the DTC step to its hand-written reference, one replay of the recorded run a block.
void dtc_step_ratio(benchmark::State& state) {
  ReferenceDtc reference;
  const std::unique_ptr<Controller<double>> controller = papers_controller();
  const ControlReference<double> wanted{ControlMode::torque, torque_reference};
  const auto by_hand = [&] {
    reference.reset();
    for (const Measurement<double>& m : run.measurements) {
      const GateSegment& applied = m.applied.segments()[0];
      benchmark::DoNotOptimize(reference.step(m.i_abc.a, m.i_abc.b, m.i_abc.c, m.u_dc,
                                              int(applied.state.upper_switches()), applied.duration_ns,
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

/// Counter `ratio`: `Drive::step` with every check to the hand-written DTC step, which has none.
void drive_step_ratio(benchmark::State& state) {
  ReferenceDtc reference;
  DriveReplay<OurDrive> ours{run};
  const auto by_hand = [&] {
    reference.reset();
    for (const Measurement<double>& m : run.measurements) {
      const GateSegment& applied = m.applied.segments()[0];
      benchmark::DoNotOptimize(reference.step(m.i_abc.a, m.i_abc.b, m.i_abc.c, m.u_dc,
                                              int(applied.state.upper_switches()), applied.duration_ns,
                                              torque_reference));
    }
  };
  for (auto _ : state) state.counters["ratio"] = paired_ratio(by_hand, ours);
}
BENCHMARK(drive_step_ratio)->Iterations(1)->Unit(benchmark::kMillisecond);

/// A whole drive with its plant, and somebody who looks at its telemetry.
class ClosedLoop {
 public:
  explicit ClosedLoop(IntegratorKind integrator) : drive_{integrator} {
    advance(ScenarioCommands::hand_shake_periods);
  }

  void advance(std::int64_t periods) {
    for (std::int64_t k = 0; k < periods; ++k) drive_.run_period(sink_);
  }

  /// False when something stopped the drive on the way.
  [[nodiscard]] bool healthy() { return drive_.healthy(); }

 private:
  struct Sink {
    void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING { torque += telemetry.torque; }
    double torque{};
  };

  BenchDrive drive_;
  Sink sink_{};
};

/// The closed loop by hand: a bare DTC step and a Runge-Kutta step a period, 15 N·m at a constant 50 rad/s.
class LoopByHand {
 public:
  LoopByHand() {
    plant_.inv_j = 0.0;
    plant_.x[4] = 50.0;
  }

  void advance(std::int64_t periods) {
    for (std::int64_t k = 0; k < periods; ++k) {
      const double i_a = plant_.i_s_a();
      const double i_b = -0.5 * i_a + half_sqrt_3 * plant_.i_s_b();
      vector_ = dtc_.step(i_a, i_b, -i_a - i_b, u_dc, upper_switches(vector_), 25'000, torque_reference);
      const SpaceVector<> u = stator_voltage(switch_states[std::size_t(vector_)], u_dc);
      plant_.step(u.alpha, u.beta, 0.0, 25e-6);
    }
  }

  [[nodiscard]] double torque() const { return dtc_.torque(); }

 private:
  static constexpr double u_dc = 530.0;
  static constexpr double half_sqrt_3 = 0.86602540378443865;
  static int upper_switches(int vector) { return int(switch_states[std::size_t(vector)].upper_switches()); }

  ReferenceRk4 plant_{};
  ReferenceDtc dtc_{};
  int vector_{0};
};

/// Counter `ratio`: a period of the closed loop, the whole drive with its plant of fixed step, to a bare DTC
/// and a Runge-Kutta step by hand.
void closed_loop_ratio(benchmark::State& state) {
  LoopByHand by_hand;
  ClosedLoop ours{IntegratorKind::fixed};
  by_hand.advance(8'000);
  ours.advance(8'000);
  constexpr int block = 100;
  for (auto _ : state) {
    state.counters["ratio"] = paired_ratio([&] { by_hand.advance(block); }, [&] { ours.advance(block); });
  }
  const bool settled = std::abs(by_hand.torque() - torque_reference) < 15.0;
  if (!settled || !ours.healthy()) state.SkipWithError("a drive does not produce its torque");
}
BENCHMARK(closed_loop_ratio)->Iterations(1)->Unit(benchmark::kMillisecond);

/// Counter `realtime_factor`: simulated time of the closed loop per CPU time, one Runge-Kutta step (or what
/// CVODE takes) a control period.
void closed_loop(benchmark::State& state, IntegratorKind integrator) {
  ClosedLoop loop{integrator};
  loop.advance(8'000);
  constexpr std::int64_t block = 1'000;
  for (auto _ : state) loop.advance(block);
  const double simulated_s = double(state.iterations()) * double(block * BenchDrive::period_ns) * 1e-9;
  state.counters["realtime_factor"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
  if (!loop.healthy()) state.SkipWithError("the drive does not produce torque");
}

void closed_loop_fixed(benchmark::State& state) {
  closed_loop(state, IntegratorKind::fixed);
}
BENCHMARK(closed_loop_fixed);

void closed_loop_cvode(benchmark::State& state) {
  closed_loop(state, IntegratorKind::cvode);
}
BENCHMARK(closed_loop_cvode);

/// Counter `ratio`: what a period of the closed loop costs after that many periods to what it costs at the
/// beginning of a run.
void closed_loop_growth(benchmark::State& state) {
  const std::int64_t age = state.range(0);
  ClosedLoop old{IntegratorKind::fixed};
  old.advance(age);
  ClosedLoop young{IntegratorKind::fixed};
  // The young loop has not grown older than 10'000 periods by the end.
  constexpr int block = 10;
  for (auto _ : state) {
    state.counters["ratio"] = paired_ratio([&] { young.advance(block); }, [&] { old.advance(block); }, 1000);
  }
  if (!old.healthy()) state.SkipWithError("the drive does not produce torque");
}
BENCHMARK(closed_loop_growth)
    ->RangeMultiplier(10)
    ->Range(10'000, 10'000'000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sextant::bench
