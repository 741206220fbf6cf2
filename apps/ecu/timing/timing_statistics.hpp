#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ecu/timing/wake_record.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/overrun.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// Wake-ups, execution times and stages over some time.
struct TimingHistograms {
  LatencyHistogram latency{};                          ///< from deadline to wake-up
  LatencyHistogram execution{};                        ///< execution time of one wake-up
  LatencyHistogram command_to_gate{};                  ///< from a frame's arrival to its first gate pattern
  std::array<LatencyHistogram, stage_count> stages{};  ///< of one control period
  std::int64_t longest_gap_ns{};                       ///< between two time stamps [ns]

  void add(const WakeRecord& wake) noexcept;
  void add(const StageRecord& stages_ns) noexcept;
};

/// Timing of the control thread from its time stamps, kept by the telemetry thread: histograms of an interval
/// and of the run, and the overruns with their causes. An overrun by a gap within a stage is counted once the
/// scheduler's statistics of that time have come.
class TimingStatistics {
 public:
  struct Parameters {
    std::int64_t gap_limit_ns{10'000};       ///< two time stamps further apart are a gap [ns]
    std::int64_t wake_period_ns{1'000'000};  ///< of the control thread [ns]
  };
  using Causes = std::array<std::uint64_t, overrun_cause_count>;
  /// Number of overruns in `worst()`. [-]
  static constexpr std::size_t worst_kept = 10;

  explicit TimingStatistics(const Parameters& parameters) : parameters_{parameters} {}

  void add(const WakeRecord& wake);
  void add(const StageRecord& stages_ns) noexcept;
  /// The kernel's counts since start; decides the causes of the overruns that ended before. A stop of the
  /// thread may span a sample: the kernel counts the switch at its beginning and the waiting time at its end.
  /// The part of a sample's growth that explained no gap therefore counts with the next sample too, and not
  /// later.
  void add(const SchedulerSample& sample);
  /// At the end: counts the pending overruns by their time stamps alone.
  void finish();
  void reset_interval() noexcept { interval_ = {}; }

  [[nodiscard]] const TimingHistograms& interval() const noexcept { return interval_; }
  [[nodiscard]] const TimingHistograms& total() const noexcept { return total_; }
  [[nodiscard]] const WakeRecord& last() const noexcept { return last_; }
  /// Overruns since start by cause. [-]
  [[nodiscard]] const Causes& causes() const noexcept { return causes_; }
  /// Overruns since start for which no gap accounts. [-]
  [[nodiscard]] std::uint64_t without_gap() const noexcept { return without_gap_; }
  /// Wake-ups since start with a gap before them, overruns or not. [-]
  [[nodiscard]] std::uint64_t gaps() const noexcept { return gaps_; }
  [[nodiscard]] const SchedulerSample& scheduler() const noexcept { return scheduler_; }
  /// The overruns with the largest latency, the largest first.
  [[nodiscard]] const std::vector<Overrun>& worst() const noexcept { return worst_; }

 private:
  /// Longest wait for a sample; then the time stamps alone decide the cause. [ns]
  static constexpr std::int64_t longest_wait_ns = 1'000'000'000;
  static constexpr std::ptrdiff_t most_waiting = 1024;

  void add_overrun(const WakeRecord& wake);
  void count_expired(std::int64_t now_ns);
  void count(const Overrun& overrun);

  Parameters parameters_;
  TimingHistograms interval_{};
  TimingHistograms total_{};
  WakeRecord last_{};
  Causes causes_{};
  std::uint64_t without_gap_{0};
  std::uint64_t gaps_{0};
  SchedulerSample scheduler_{};
  SchedulerSample left_over_{};     // growth of the last sample that has explained no gap
  std::vector<Overrun> pending_{};  // in the order of their deadlines
  std::vector<Overrun> worst_{};
};

}  // namespace sextant::ecu
