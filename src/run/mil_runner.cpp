#include "sextant/run/mil_runner.hpp"

#include <chrono>

#include "observed_run.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/run/progress_ticker.hpp"

namespace sextant {
namespace {

/// Keeps the telemetry of the last period.
struct LastTelemetry {
  Telemetry<double> value{};
  void push(const Telemetry<double>& t) noexcept SEXTANT_NONBLOCKING { value = t; }
};

}  // namespace

void MilResult::note_faults(FaultSet latched, Fault first, std::int64_t t_ns) {
  if (!latched.any() || latched == faults) return;
  if (!faults.any()) {
    first_fault = first;
    fault_ns = t_ns;
    fault_times.push_back({first, t_ns});
    faults.set(first);
  }
  for (int k = 0; k < fault_count; ++k) {
    const auto fault = static_cast<Fault>(k);
    if (latched.test(fault) && !faults.test(fault)) fault_times.push_back({fault, t_ns});
  }
  faults |= latched;
}

MilResult MilRunner::run(const Scenario& scenario, TraceRecorder* trace, const Progress& progress) {
  return std::visit([&](auto* io) { return run(*io, scenario, trace, progress); }, io_);
}

template <class SomeIo>
MilResult MilRunner::run(SomeIo& io, const Scenario& scenario, TraceRecorder* trace,
                         const Progress& progress) {
  ObservedRun run{scenario, period_ns_, io, controller_, trace};
  LastTelemetry telemetry;
  ProgressTicker ticker{progress, 1024};
  bool stopped = false;
  const auto begin = std::chrono::steady_clock::now();

  std::int64_t t_ns = -std::int64_t{ScenarioCommands::hand_shake_periods} * period_ns_;
  for (; t_ns <= scenario.duration_ns && io.healthy(); t_ns += period_ns_) {
    run_cycle(t_ns, io, run.commands(), drive_, telemetry);
    if (!run.period(telemetry.value)) break;
    if (t_ns < 0 || ticker.tick(double(t_ns) / double(scenario.duration_ns))) continue;
    stopped = true;
    break;
  }

  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  MilResult result = run.result(wall.count());
  result.stopped = stopped;
  result.final_state = drive_.state();
  return result;
}

}  // namespace sextant
