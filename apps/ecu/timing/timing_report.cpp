#include "ecu/timing/timing_report.hpp"

#include <cstddef>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "ecu/timing/microseconds.hpp"

namespace sextant::ecu {
namespace {

void print_row(std::FILE* out, const char* name, const LatencyHistogram& histogram, int decimals) {
  const LatencySummary s = histogram.summary();
  if (s.count == 0) return;
  fmt::print(out, "  {:<16}", name);
  for (const std::int64_t ns : {s.p50_ns, s.p99_ns, s.p99_9_ns, s.p99_99_ns, s.max_ns}) {
    fmt::print(out, " {:>10.{}f}", microseconds(ns), decimals);
  }
  fmt::print(out, "\n");
}

void print_overruns(std::FILE* out, const TimingStatistics& statistics) {
  for (std::size_t i = 0; i < overrun_cause_count; ++i) {
    if (statistics.causes()[i] == 0) continue;
    fmt::print(out, "  {:<18} {}\n", to_string(static_cast<OverrunCause>(i)), statistics.causes()[i]);
  }
  fmt::print(out, "  {:<18} {}\n", "without a gap", statistics.without_gap());
  for (const Overrun& overrun : statistics.worst()) {
    fmt::print(out, "    at {:.6f} s: {:.1f} us late, ", double(overrun.t_ns) * 1e-9,
               microseconds(overrun.latency_ns));
    if (overrun.gap.longest_ns > 0) {
      fmt::print(out, "gap of {:.1f} us, {}: ", microseconds(overrun.gap.longest_ns),
                 to_string(overrun.gap.place));
    }
    fmt::print(out, "{}\n", to_string(overrun.cause));
  }
}

}  // namespace

void print_periods(std::FILE* out, std::uint64_t periods, std::uint64_t periods_missed,
                   std::uint64_t overruns) {
  fmt::print(out, "control periods {} run, {} missed in {} overruns\n", periods, periods_missed, overruns);
}

void print_timing(std::FILE* out, const TimingStatistics& statistics) {
  const WakeRecord& last = statistics.last();
  const TimingHistograms& total = statistics.total();
  print_periods(out, last.periods, last.periods_missed, last.overruns);
  fmt::print(out, "  {:<16} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "[us]", "p50", "p99", "p99.9", "p99.99",
             "max");
  print_row(out, "wake-up latency", total.latency, 1);
  print_row(out, "execution time", total.execution, 1);
  for (std::size_t i = 0; i < stage_count; ++i) {
    print_row(out, fmt::format("  {}", to_string(static_cast<Stage>(i))).c_str(), total.stages[i], 3);
  }
  print_row(out, "command to gate", total.command_to_gate, 1);
  fmt::print(out, "  longest time between two time stamps {:.1f} us; {} wake-ups with a gap before them\n",
             microseconds(total.longest_gap_ns), statistics.gaps());
  if (const SchedulerSample& kernel = statistics.scheduler(); kernel.valid) {
    fmt::print(
        out,
        "  control thread: {} page faults, {} voluntary and {} involuntary switches, {:.1f} us ready without "
        "a processor; {:.0f} ms stolen from all CPUs\n",
        kernel.minor_faults + kernel.major_faults, kernel.voluntary_switches, kernel.involuntary_switches,
        microseconds(kernel.run_delay_ns), double(kernel.steal_ns) * 1e-6);
  }
  if (last.overruns > 0) print_overruns(out, statistics);
}

nlohmann::json to_json(const LatencyHistogram& histogram) {
  const LatencySummary s = histogram.summary();
  nlohmann::json buckets = nlohmann::json::array();
  histogram.for_each_bucket([&buckets](std::int64_t ns, std::uint64_t count) {
    buckets.push_back(nlohmann::json::array({ns, count}));
  });
  return {{"count", s.count},       {"mean_ns", s.mean_ns},     {"p50_ns", s.p50_ns}, {"p99_ns", s.p99_ns},
          {"p99_9_ns", s.p99_9_ns}, {"p99_99_ns", s.p99_99_ns}, {"max_ns", s.max_ns}, {"buckets", buckets}};
}

void write_timing(const std::string& file, const TimingStatistics& statistics,
                  const LatencyHistogram& hand_over) {
  const TimingHistograms& total = statistics.total();
  const WakeRecord& last = statistics.last();
  nlohmann::json causes;
  for (std::size_t i = 0; i < overrun_cause_count; ++i) {
    causes[to_string(static_cast<OverrunCause>(i))] = statistics.causes()[i];
  }
  nlohmann::json stages;
  for (std::size_t i = 0; i < stage_count; ++i) {
    stages[to_string(static_cast<Stage>(i))] = to_json(total.stages[i]);
  }
  const nlohmann::json timing{{"periods", last.periods},
                              {"periods_missed", last.periods_missed},
                              {"overruns", last.overruns},
                              {"overruns_by_cause", causes},
                              {"overruns_without_gap", statistics.without_gap()},
                              {"gaps", statistics.gaps()},
                              {"longest_gap_ns", total.longest_gap_ns},
                              {"wake_latency", to_json(total.latency)},
                              {"execution", to_json(total.execution)},
                              {"command_to_gate", to_json(total.command_to_gate)},
                              {"command_hand_over", to_json(hand_over)},
                              {"stages", stages}};
  std::ofstream out{file};
  out << timing.dump() << '\n';
  out.close();
  if (!out) throw std::runtime_error("the timing cannot be written to \"" + file + "\"");
}

}  // namespace sextant::ecu
