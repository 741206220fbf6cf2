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

/// What the telemetry thread makes of the control thread's time stamps: histograms of an interval and of the
/// run, and the overruns with their causes. A gap within a stage waits for what the scheduler's statistics
/// say of its time before it is counted.
class TimingStatistics {
 public:
  struct Parameters {
    std::int64_t gap_limit_ns{10'000};       ///< two time stamps further apart are a gap [ns]
    std::int64_t wake_period_ns{1'000'000};  ///< of the control thread [ns]
  };
  using Causes = std::array<std::uint64_t, overrun_cause_count>;
  /// So many of the latest wake-ups are kept for the report. [-]
  static constexpr std::size_t worst_kept = 10;

  explicit TimingStatistics(const Parameters& parameters) : parameters_{parameters} {}

  void add(const WakeRecord& wake);
  void add(const StageRecord& stages_ns) noexcept;
  /// What the kernel counted since start; decides the causes of the overruns that were over by then. A stop
  /// may lie across a sample: the kernel counts the switch where it begins and the waiting where it ends. So
  /// what no gap has spent of a sample's growth serves the next sample as well, and no other.
  void add(const SchedulerSample& sample);
  /// At the end: what still waits is counted by its time stamps alone.
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
  /// Without a sample for so long the time stamps alone decide the cause. [ns]
  static constexpr std::int64_t longest_wait_ns = 1'000'000'000;
  static constexpr std::ptrdiff_t most_waiting = 1024;

  void add_overrun(const WakeRecord& wake);
  void give_up_waiting(std::int64_t now_ns);
  void count(const Overrun& overrun);

  Parameters parameters_;
  TimingHistograms interval_{};
  TimingHistograms total_{};
  WakeRecord last_{};
  Causes causes_{};
  std::uint64_t without_gap_{0};
  std::uint64_t gaps_{0};
  SchedulerSample scheduler_{};
  SchedulerSample left_over_{};     // of what the last sample has grown by: it has explained nothing yet
  std::vector<Overrun> pending_{};  // in the order of their deadlines
  std::vector<Overrun> worst_{};
};

}  // namespace sextant::ecu
