#include "ecu/timing_file.hpp"

#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace sextant::ecu {

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
  for (std::size_t i = 0; i < miss_cause_count; ++i) {
    causes[to_string(static_cast<MissCause>(i))] = statistics.causes()[i];
  }
  nlohmann::json stages;
  for (std::size_t i = 0; i < stage_count; ++i) {
    stages[to_string(static_cast<Stage>(i))] = to_json(total.stages[i]);
  }
  const nlohmann::json timing{{"periods", last.periods},
                              {"periods_skipped", last.periods_skipped},
                              {"overruns", last.overruns},
                              {"misses_by_cause", causes},
                              {"misses_without_gap", statistics.without_gap()},
                              {"gaps", statistics.gaps()},
                              {"longest_gap_ns", total.longest_gap_ns},
                              {"wake_latency", to_json(total.latency)},
                              {"body", to_json(total.body)},
                              {"command_to_gate", to_json(total.command_to_gate)},
                              {"command_hand_over", to_json(hand_over)},
                              {"stages", stages}};
  std::ofstream out{file};
  out << timing.dump() << '\n';
  out.close();
  if (!out) throw std::runtime_error("the timing cannot be written to \"" + file + "\"");
}

}  // namespace sextant::ecu
