// instruction_probe WHAT N [NOPS]: runs N steps of one thing, so that a counter of instructions (callgrind)
// tells what a step costs: the difference of two runs by the difference of their N. NOPS seeds a slow-down of
// so many instructions a step. Without arguments: the things it knows. scripts/check_instructions runs it.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "bench/bench_drive.hpp"
#include "bench/drive_replay.hpp"
#include "bench/keep.hpp"
#include "bench/recorded_run.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant::bench {
namespace {

/// N instructions that do nothing.
void waste(long n) {
  if (n > 0) asm volatile("1: dec %0\n jnz 1b" : "+r"(n) : : "cc");
}

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "instruction_probe: %s\n", what);
  std::exit(2);
}

struct LastTelemetry {
  Telemetry<double> value{};
  void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING { value = telemetry; }
};

void dtc_step(long steps, long nops) {
  const RecordedRun run = record_run();
  const std::unique_ptr<Controller<double>> controller =
      std::make_unique<DirectTorqueController<double>>(DirectTorqueController<double>::Parameters{});
  const ControlReference<double> reference{ControlMode::torque, torque_reference};
  for (long n = 0; n < steps; ++n) {
    const std::size_t k = std::size_t(n) % run.measurements.size();
    if (k == 0) controller->reset();
    keep(controller->step(run.measurements[k], reference));
    waste(nops / 2);
  }
}

void drive_step(long steps, long nops) {
  const RecordedRun run = record_run();
  DriveReplay<OurDrive> replay{run};
  for (long n = 0; n < steps; ++n) {
    replay.next();
    waste(nops / 2);
  }
  // Every replay must cost the same: it ends with the flux with which the second one did.
  DriveReplay<OurDrive> second{run};
  second();
  second();
  if (steps % recorded_periods != 0) return;
  const SpaceVector<double> drift =
      replay.contestant().controller.estimate().psi_s - second.contestant().controller.estimate().psi_s;
  if (!(magnitude(drift) < 1e-9)) fail("the flux drifts from replay to replay");
  if (replay.contestant().drive.state() != DriveState::torque) fail("the drive makes no torque");
}

void plant_period(IntegratorKind kind, long steps, long nops) {
  using Plant = DrivePlant<double>;
  const RecordedRun run = record_run();
  Plant plant{{}};
  std::unique_ptr<PlantIntegrator<Plant>> integrator = std::make_unique<FixedStepIntegrator<Plant>>();
  if (kind == IntegratorKind::cvode) integrator = std::make_unique<CvodeIntegrator<Plant>>();
  for (long n = 0; n < steps; ++n) {
    plant.set_inputs(
        {run.patterns[std::size_t(n) % run.patterns.size()].last_state(), 530.0, 15.0, false, 0.0});
    if (!integrator->advance(plant, 25'000)) std::exit(2);
    waste(nops / 2);
  }
}

void closed_loop_period(IntegratorKind kind, long steps, long nops) {
  BenchDrive drive{kind};
  LastTelemetry telemetry;
  for (long n = 0; n < steps; ++n) {
    drive.run_period(telemetry);
    keep(telemetry.value);
    waste(nops / 2);
  }
}

void telemetry_push(long steps, long nops) {
  Ring<Telemetry<double>> ring{1024};
  const Telemetry<double> telemetry{};
  Telemetry<double> taken;
  for (long n = 0; n < steps; ++n) {
    keep(telemetry);
    if (!ring.push(telemetry) || !ring.pop(taken)) std::exit(2);
    keep(taken);
    waste(nops / 2);
  }
}

struct Probe {
  const char* name;
  void (*run)(long steps, long nops);
};

int main_of(int argc, char** argv) {
  const Probe probes[] = {
      {"dtc_step", dtc_step},
      {"drive_step", drive_step},
      {"plant_period_fixed", [](long n, long nops) { plant_period(IntegratorKind::fixed, n, nops); }},
      {"plant_period_cvode", [](long n, long nops) { plant_period(IntegratorKind::cvode, n, nops); }},
      {"closed_loop_period_fixed",
       [](long n, long nops) { closed_loop_period(IntegratorKind::fixed, n, nops); }},
      {"telemetry_push_and_pop", telemetry_push},
  };
  if (argc == 1) {
    for (const Probe& probe : probes) std::puts(probe.name);
    return 0;
  }
  for (const Probe& probe : probes) {
    if (argc < 3 || std::strcmp(argv[1], probe.name) != 0) continue;
    probe.run(std::atol(argv[2]), argc > 3 ? std::atol(argv[3]) : 0);
    return 0;
  }
  std::fprintf(stderr,
               "instruction_probe: usage: instruction_probe WHAT N [NOPS]; alone it lists what there is\n");
  return 1;
}

}  // namespace
}  // namespace sextant::bench

int main(int argc, char** argv) {
  return sextant::bench::main_of(argc, argv);
}
