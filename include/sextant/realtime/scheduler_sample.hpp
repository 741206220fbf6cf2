#pragma once

#include <cstdint>
#include <string>

namespace sextant {

/// The kernel's counts for one thread and for the machine, since the start of each.
struct SchedulerSample {
  std::int64_t t_ns{};                   ///< when it was taken, CLOCK_MONOTONIC [ns]
  std::int64_t run_delay_ns{};           ///< ready to run but without a processor [ns]
  std::int64_t steal_ns{};               ///< of all CPUs, taken by the hypervisor; in steps of 10 ms [ns]
  std::uint64_t voluntary_switches{};    ///< the thread yielded the processor [-]
  std::uint64_t involuntary_switches{};  ///< the thread was preempted [-]
  std::uint64_t minor_faults{};          ///< page faults without a disk [-]
  std::uint64_t major_faults{};          ///< page faults with one [-]
  bool valid{false};                     ///< the thread was there and everything could be read

  /// Growth since an earlier one, which may be empty; time and validity are the later one's.
  [[nodiscard]] SchedulerSample since(const SchedulerSample& before) const noexcept;
  /// Growth together with what an earlier one has left over; time and validity are the later one's.
  [[nodiscard]] SchedulerSample and_left_over(const SchedulerSample& earlier) const noexcept;
  /// Member by member no more than `limit`; time and validity stay.
  [[nodiscard]] SchedulerSample at_most(const SchedulerSample& limit) const noexcept;

  /// Whether this growth can explain a stop of the thread for gap_ns [ns]: it was preempted and waited for a
  /// processor for at least that long, or the hypervisor took at least that much time. The growth is a sum
  /// over the time between two samples and, for stolen time, over all CPUs: a large one is possible evidence,
  /// a small one excludes the machine as the cause.
  [[nodiscard]] bool explains(std::int64_t gap_ns) const noexcept {
    return valid && (steal_ns >= gap_ns || (involuntary_switches > 0 && run_delay_ns >= gap_ns));
  }

  /// Subtracts gap_ns [ns] and one switch from the growth, so that it explains no other gap.
  void spend(std::int64_t gap_ns) noexcept {
    if (involuntary_switches > 0 && run_delay_ns >= gap_ns) {
      --involuntary_switches;
      run_delay_ns -= gap_ns;
    } else {
      steal_ns -= gap_ns;
    }
  }
};

/// Reads the statistics of a thread of this process from /proc/self/task/<id>/{schedstat,status,stat} and
/// /proc/stat (proc(5)). Any thread may do so without an effect on the observed one.
class SchedulerSampler {
 public:
  /// thread_id: as from gettid(). root: the kernel's /proc.
  explicit SchedulerSampler(int thread_id, const std::string& root = "/proc");

  [[nodiscard]] SchedulerSample sample() const;

 private:
  std::string task_;
  std::string machine_;
};

}  // namespace sextant
