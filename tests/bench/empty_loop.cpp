// A periodic thread without a drive: what the machine, the kernel and the clock cost a control thread that
// waits in the same way. Its body is empty, or stands in for one that takes as long (--busy-ns) or touches as
// much memory (--lines). scripts/bench runs it in turns with sextant-ecu.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "ecu/timing/timing_report.hpp"
#include "sextant/realtime/cache_line.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace {

struct Options {
  double period_us{25.0};
  double duration_s{1.0};
  std::string wait{"spin"};
  double busy_ns{0.0};
  std::size_t lines{0};
  double tick_lead_us{0.0};
  sextant::RealtimeParameters realtime{.wake_every_periods = 1};
};

struct Result {
  sextant::LatencyHistogram latency{};
  sextant::LatencyHistogram execution{};  // between the reading of the clock at the wake-up and the next
  sextant::RightsReport rights{};
};

/// Takes time and nothing else: a chain of operations on registers, each of which waits for the one before.
class BusyWork {
 public:
  /// For busy_ns at the processor's present speed [ns].
  explicit BusyWork(double busy_ns) noexcept {
    constexpr int trial = 1'000;
    std::array<std::int64_t, 101> taken_ns;
    steps_ = trial;
    for (std::int64_t& one : taken_ns) {
      const std::int64_t begin_ns = sextant::now_ns();
      run();
      one = sextant::now_ns() - begin_ns;
    }
    std::ranges::nth_element(taken_ns, taken_ns.begin() + 50);
    steps_ = int(busy_ns * trial / double(taken_ns[50]));
  }

  void run() noexcept {
    double x = 1.0;
    for (int i = 0; i < steps_; ++i) {
      x *= 0.999999;
      asm volatile("" : "+x"(x));  // keeps the compiler from leaving it out
    }
  }

 private:
  int steps_{0};
};

/// Touches memory and computes nothing: reads and writes a word in each of its cache lines.
class LineWork {
 public:
  explicit LineWork(std::size_t lines) : lines_(lines) {}

  void run() noexcept {
    for (Line& line : lines_) {
      ++line.word;
      asm volatile("" ::: "memory");
    }
  }

 private:
  struct alignas(sextant::cache_line) Line {
    std::uint64_t word{0};
  };
  std::vector<Line> lines_;
};

void loop(const Options& options, Result& result) {
  const auto period_ns = std::int64_t(options.period_us * 1e3);
  result.rights = sextant::set_up_control_thread(options.realtime, period_ns);
  BusyWork busy{options.busy_ns};
  LineWork lines{options.lines};
  sextant::PeriodicTask task{{.period_ns = period_ns, .wake_every_periods = 1}, options.realtime.wait};
  const std::int64_t end_ns = task.start() + std::int64_t(options.duration_s * 1e9);
  while (task.woken_ns() < end_ns) {
    const sextant::WakeSchedule::Wake wake = task.wait();
    busy.run();
    lines.run();
    const std::int64_t execution_ns = sextant::now_ns() - task.woken_ns();
    result.latency.record(wake.latency_ns);
    result.execution.record(execution_ns);
  }
}

sextant::WaitMode wait_mode(const std::string& name) {
  for (const auto mode : {sextant::WaitMode::sleep, sextant::WaitMode::spin, sextant::WaitMode::hybrid}) {
    if (name == to_string(mode)) return mode;
  }
  throw CLI::ValidationError("--wait", "it is sleep, spin or hybrid");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"A periodic thread without a drive. Prints its timing as JSON."};
  Options options;
  app.add_option("--period-us", options.period_us)->check(CLI::Range(1.0, 1e6));
  app.add_option("--duration", options.duration_s, "[s]")->check(CLI::Range(0.001, 1e4));
  app.add_option("--wait", options.wait, "sleep, spin or hybrid");
  app.add_option("--busy-ns", options.busy_ns, "the body computes for so long, in registers")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--lines", options.lines, "the body reads and writes so many cache lines")
      ->check(CLI::Range(0, 100'000));
  app.add_option("--tick-lead-us", options.tick_lead_us, "as realtime.tick_lead_us")
      ->check(CLI::Range(0.0, 1e5));
  app.add_option("--cpu", options.realtime.cpu);
  app.add_option("--priority", options.realtime.priority)->check(CLI::Range(1, 98));
  try {
    app.parse(argc, argv);
    options.realtime.wait.mode = wait_mode(options.wait);
    options.realtime.wait.tick_lead_ns = std::int64_t(options.tick_lead_us * 1e3);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  }
  Result result;
  std::thread{loop, std::cref(options), std::ref(result)}.join();
  for (const std::string& refusal : result.rights.refusals) std::fprintf(stderr, "%s\n", refusal.c_str());
  const nlohmann::json timing{{"wake_latency", sextant::ecu::to_json(result.latency)},
                              {"execution", sextant::ecu::to_json(result.execution)},
                              {"real_time_scheduling", result.rights.real_time_scheduling}};
  std::printf("%s\n", timing.dump().c_str());
  return 0;
}
