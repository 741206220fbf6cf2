#include "ecu/timing_report.hpp"

#include <fmt/format.h>

namespace sextant::ecu {
namespace {

double us(std::int64_t ns) {
  return double(ns) * 1e-3;
}

void print_row(std::FILE* out, const char* name, const LatencyHistogram& histogram, int decimals) {
  const LatencySummary s = histogram.summary();
  if (s.count == 0) return;
  fmt::print(out, "  {:<16}", name);
  for (const std::int64_t ns : {s.p50_ns, s.p99_ns, s.p99_9_ns, s.p99_99_ns, s.max_ns}) {
    fmt::print(out, " {:>10.{}f}", us(ns), decimals);
  }
  fmt::print(out, "\n");
}

void print_misses(std::FILE* out, const TimingStatistics& statistics) {
  for (std::size_t i = 0; i < miss_cause_count; ++i) {
    if (statistics.causes()[i] == 0) continue;
    fmt::print(out, "  {:<18} {}\n", to_string(static_cast<MissCause>(i)), statistics.causes()[i]);
  }
  fmt::print(out, "  {:<18} {}\n", "without a gap", statistics.without_gap());
  for (const Miss& miss : statistics.worst()) {
    fmt::print(out, "    at {:.6f} s: {:.1f} us late, ", double(miss.t_ns) * 1e-9, us(miss.latency_ns));
    if (miss.gap.longest_ns > 0) {
      fmt::print(out, "gap of {:.1f} us, {}: ", us(miss.gap.longest_ns), to_string(miss.gap.place));
    }
    fmt::print(out, "{}\n", to_string(miss.cause));
  }
}

}  // namespace

void print_timing(std::FILE* out, const TimingStatistics& statistics) {
  const WakeRecord& last = statistics.last();
  const TimingHistograms& total = statistics.total();
  fmt::print(out, "control periods {} run, {} missed in {} overruns\n", last.periods, last.periods_skipped,
             last.overruns);
  fmt::print(out, "  {:<16} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "[us]", "p50", "p99", "p99.9", "p99.99",
             "max");
  print_row(out, "wake-up latency", total.latency, 1);
  print_row(out, "work per wake-up", total.body, 1);
  for (std::size_t i = 0; i < stage_count; ++i) {
    print_row(out, fmt::format("  {}", to_string(static_cast<Stage>(i))).c_str(), total.stages[i], 3);
  }
  print_row(out, "command to gate", total.command_to_gate, 1);
  fmt::print(out, "  longest time between two time stamps {:.1f} us; {} wake-ups with a gap before them\n",
             us(total.longest_gap_ns), statistics.gaps());
  if (const SchedulerSample& kernel = statistics.scheduler(); kernel.valid) {
    fmt::print(
        out,
        "  control thread: {} page faults, {} switches of its own, {} forced on it, {:.1f} us ready without "
        "a processor; {:.0f} ms stolen from all CPUs\n",
        kernel.minor_faults + kernel.major_faults, kernel.voluntary_switches, kernel.involuntary_switches,
        us(kernel.run_delay_ns), double(kernel.steal_ns) * 1e-6);
  }
  if (last.overruns > 0) print_misses(out, statistics);
}

}  // namespace sextant::ecu
