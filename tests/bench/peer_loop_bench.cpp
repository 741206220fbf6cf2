#include <benchmark/benchmark.h>

#include "bench/bench_drive.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant::bench {
namespace {

struct LastTelemetry {
  Telemetry<double> value{};
  void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING { value = telemetry; }
};

/// The whole drive with its plant at the operating point at which other simulators are timed. Counter
/// `realtime_factor`: simulated time by CPU time.
void peer_loop(benchmark::State& state, IntegratorKind kind) {
  BenchDrive drive{kind};
  LastTelemetry telemetry;
  for (int k = 0; k < 8'000; ++k) drive.run_period(telemetry);
  for (auto _ : state) {
    drive.run_period(telemetry);
    benchmark::DoNotOptimize(&telemetry);
    benchmark::ClobberMemory();
  }
  if (!drive.healthy()) state.SkipWithError("the drive makes no torque");
  state.counters["realtime_factor"] = benchmark::Counter(
      1e-9 * double(BenchDrive::period_ns) * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(peer_loop, fixed, IntegratorKind::fixed);
BENCHMARK_CAPTURE(peer_loop, cvode, IntegratorKind::cvode);

}  // namespace
}  // namespace sextant::bench
