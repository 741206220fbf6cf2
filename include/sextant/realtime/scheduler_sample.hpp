#pragma once

#include <cstdint>
#include <string>

namespace sextant {

/// What the kernel has counted for one thread and for the machine, since each of them started.
struct SchedulerSample {
  std::int64_t t_ns{};                   ///< when it was taken, CLOCK_MONOTONIC [ns]
  std::int64_t run_delay_ns{};           ///< ready to run but without a processor [ns]
  std::int64_t steal_ns{};               ///< of all CPUs, taken by the hypervisor; in steps of 10 ms [ns]
  std::uint64_t voluntary_switches{};    ///< the thread gave the processor away [-]
  std::uint64_t involuntary_switches{};  ///< it was taken from the thread [-]
  std::uint64_t minor_faults{};          ///< page faults without a disk [-]
  std::uint64_t major_faults{};          ///< page faults with one [-]
  bool valid{false};                     ///< the thread was there and everything could be read

  /// Growth since an earlier one, which may be empty; time and validity are the later one's.
  [[nodiscard]] SchedulerSample since(const SchedulerSample& before) const noexcept;
  /// Growth together with what an earlier one has left over; time and validity are the later one's.
  [[nodiscard]] SchedulerSample and_left_over(const SchedulerSample& earlier) const noexcept;
  /// Member by member no more than `limit`; time and validity stay.
  [[nodiscard]] SchedulerSample at_most(const SchedulerSample& limit) const noexcept;

  /// Whether growth like this can explain that a thread stood still for gap_ns [ns]: the processor was taken
  /// from it and it waited for one for at least that long, or the hypervisor took at least that much time.
  /// It is a sum over the time between two samples and, for stolen time, over all CPUs: large enough says
  /// that the machine can have done it; too small says that it has not.
  [[nodiscard]] bool explains(std::int64_t gap_ns) const noexcept {
    return valid && (steal_ns >= gap_ns || (involuntary_switches > 0 && run_delay_ns >= gap_ns));
  }

  /// Takes gap_ns [ns] out of what explained it, and the switch with it, so that it explains no other gap.
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
/// /proc/stat (proc(5)). Any other thread may do so: the observed one notices nothing.
class SchedulerSampler {
 public:
  /// thread_id: as gettid() says it. root: where the kernel's /proc is.
  explicit SchedulerSampler(int thread_id, const std::string& root = "/proc");

  [[nodiscard]] SchedulerSample sample() const;

 private:
  std::string task_;
  std::string machine_;
};

}  // namespace sextant
