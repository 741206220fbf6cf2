// A periodic thread with no work: what the machine, the kernel and the clock cost a control thread that waits
// in the same way. scripts/bench runs it in turns with sextant-ecu.
#include <cstdio>
#include <exception>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "ecu/timing_file.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace {

struct Options {
  double period_us{25.0};
  double duration_s{1.0};
  std::string wait{"spin"};
  sextant::RealtimeParameters realtime{.wake_every_periods = 1};
};

struct Result {
  sextant::LatencyHistogram latency{};
  sextant::LatencyHistogram body{};  // between the reading of the clock at the wake-up and the next
  sextant::RightsReport rights{};
};

void loop(const Options& options, Result& result) {
  const auto period_ns = std::int64_t(options.period_us * 1e3);
  result.rights = sextant::set_up_control_thread(options.realtime, period_ns);
  sextant::PeriodicTask task{{.period_ns = period_ns, .wake_every_periods = 1}, options.realtime.wait};
  const std::int64_t end_ns = task.start() + std::int64_t(options.duration_s * 1e9);
  while (task.woken_ns() < end_ns) {
    const sextant::WakeSchedule::Wake wake = task.wait();
    const std::int64_t body_ns = sextant::now_ns() - task.woken_ns();
    result.latency.record(wake.latency_ns);
    result.body.record(body_ns);
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
  CLI::App app{"A periodic thread with no work. Prints its timing as JSON."};
  Options options;
  app.add_option("--period-us", options.period_us)->check(CLI::Range(1.0, 1e6));
  app.add_option("--duration", options.duration_s, "[s]")->check(CLI::Range(0.001, 1e4));
  app.add_option("--wait", options.wait, "sleep, spin or hybrid");
  app.add_option("--cpu", options.realtime.cpu);
  app.add_option("--priority", options.realtime.priority)->check(CLI::Range(1, 98));
  try {
    app.parse(argc, argv);
    options.realtime.wait.mode = wait_mode(options.wait);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  }
  Result result;
  std::thread{loop, std::cref(options), std::ref(result)}.join();
  for (const std::string& refusal : result.rights.refusals) std::fprintf(stderr, "%s\n", refusal.c_str());
  const nlohmann::json timing{{"wake_latency", sextant::ecu::to_json(result.latency)},
                              {"body", sextant::ecu::to_json(result.body)},
                              {"real_time_scheduling", result.rights.real_time_scheduling}};
  std::printf("%s\n", timing.dump().c_str());
  return 0;
}
