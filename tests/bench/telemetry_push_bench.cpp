#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/bench_drive.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant::bench {
namespace {

using TelemetryRing = Ring<Telemetry<double>>;

constexpr std::size_t a_second = 40'001;  // as the live drive's ring at 25 µs
constexpr int warm_up_periods = 8'000;    // magnetised and settled

/// Takes what is queued every millisecond on a thread of its own, as the telemetry thread does.
class Reader {
 public:
  explicit Reader(TelemetryRing& ring) : thread_{[this, &ring] { drain(ring); }} {}
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() {
    stop_.store(true, std::memory_order_relaxed);
    thread_.join();
  }

 private:
  void drain(TelemetryRing& ring) {
    Telemetry<double> value;
    while (!stop_.load(std::memory_order_relaxed)) {
      while (ring.pop(value)) benchmark::DoNotOptimize(&value);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Times each push of a running drive by itself, with the caches as drive and plant leave them.
class TimedSink {
 public:
  TimedSink(TelemetryRing& ring, std::size_t periods) : ring_{ring} {
    push_ns_.reserve(periods);
    clock_ns_.reserve(periods);
  }

  void push(const Telemetry<double>& value) noexcept {
    const auto begin = std::chrono::steady_clock::now();
    const auto empty = std::chrono::steady_clock::now();
    if (!ring_.push(value)) ++refused_;
    const auto end = std::chrono::steady_clock::now();
    if (push_ns_.size() == push_ns_.capacity()) return;
    clock_ns_.push_back(std::chrono::duration<double, std::nano>(empty - begin).count());
    push_ns_.push_back(std::chrono::duration<double, std::nano>(end - empty).count());
  }

  /// Of a push and the one reading of the clock that times it. [ns]
  [[nodiscard]] double quantile_ns(double q) { return quantile(push_ns_, q); }
  /// Median of that reading alone. [ns]
  [[nodiscard]] double clock_ns() { return quantile(clock_ns_, 0.5); }
  [[nodiscard]] std::size_t refused() const noexcept { return refused_; }

 private:
  static double quantile(std::vector<double>& values, double q) {
    const auto at = values.begin() + std::ptrdiff_t(q * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  }

  TelemetryRing& ring_;
  std::vector<double> push_ns_{};
  std::vector<double> clock_ns_{};
  std::size_t refused_{0};
};

struct Discard {
  void push(const Telemetry<double>&) noexcept {}
};

void run(benchmark::State& state, TelemetryRing& ring, std::size_t periods, bool room) {
  BenchDrive drive;
  Discard discard;
  for (int k = 0; k < warm_up_periods; ++k) drive.run_period(discard);
  for (auto _ : state) {
    TimedSink sink{ring, periods};
    for (std::size_t k = 0; k < periods; ++k) drive.run_period(sink);
    state.counters["clock_ns"] = sink.clock_ns();
    state.counters["p50_ns"] = sink.quantile_ns(0.5);
    state.counters["p99_ns"] = sink.quantile_ns(0.99);
    state.counters["p999_ns"] = sink.quantile_ns(0.999);
    if (room == (sink.refused() != 0)) state.SkipWithError("the ring was full or empty against the plan");
  }
  if (!drive.healthy()) state.SkipWithError("the drive makes no torque");
}

/// Counters p50_ns, p99_ns, p999_ns: one push on the control path into a ring that the telemetry thread
/// drains, with one reading of the clock; clock_ns: that reading alone.
void telemetry_push(benchmark::State& state) {
  TelemetryRing ring{a_second};
  const Reader reader{ring};
  run(state, ring, 200'000, true);
}
BENCHMARK(telemetry_push)->Iterations(1)->Unit(benchmark::kMillisecond);

/// The same into a ring that nobody drains yet.
void telemetry_push_unread(benchmark::State& state) {
  TelemetryRing ring{a_second};
  run(state, ring, a_second, true);
}
BENCHMARK(telemetry_push_unread)->Iterations(1)->Unit(benchmark::kMillisecond);

/// The same into a full ring: every push is refused, and none waits.
void telemetry_push_full(benchmark::State& state) {
  TelemetryRing ring{16};
  while (ring.push({})) continue;
  run(state, ring, 200'000, false);
}
BENCHMARK(telemetry_push_full)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sextant::bench
