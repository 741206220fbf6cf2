#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {

/// Result of a request to the operating system. A refusal is no exception: only
/// require_rights() and require_room_for_spinning() throw.
struct Grant {
  bool granted{false};
  std::string sentence{};  ///< empty when granted, else what was refused, why, and the remedy
};

/// SCHED_FIFO for the calling thread, so that no ordinary thread delays it. Priority 1…99.
[[nodiscard]] Grant use_fifo_scheduling(int priority);

/// SCHED_DEADLINE for the calling thread: runtime_ns of processor time in each period_ns, before its end
/// [ns]. The kernel grants it only while the sum of all such threads fits into the CPUs, and only to threads
/// that may run on every CPU.
[[nodiscard]] Grant use_deadline_scheduling(std::int64_t runtime_ns, std::int64_t period_ns);

/// Binds the calling thread to one CPU, so that it neither migrates nor finds cold caches.
[[nodiscard]] Grant bind_to_cpu(int cpu);

/// Takes a CPU out of those of the calling thread and of threads that it starts from now on, so that a thread
/// that is bound to it later has it alone. Nothing where the CPU is -1; refused where no other is left.
[[nodiscard]] Grant keep_off_cpu(int cpu);

/// Keeps small what lock_memory() will lock: all threads share one heap, where each would reserve 64 MiB of
/// addresses for one of its own, and the stacks of threads that start from now on have 1 MiB instead of 8
/// MiB. For the beginning of a program, before its first thread starts.
void reserve_little_memory();

/// Keeps all present and future memory of the process resident, and freed heap memory in the process.
[[nodiscard]] Grant lock_memory();

/// Takes 8 MiB of heap, touches them and gives them back, so that they stay with the process after
/// lock_memory() and later allocations of any thread find resident memory.
void prefault_heap();

/// Touches the next 256 KiB of the calling thread's stack, so that their page faults happen now.
void prefault_stack() noexcept;

/// Names the calling thread for `ps`, `top` and traces; at most 15 characters.
[[nodiscard]] Grant name_thread(const std::string& name);

/// Whether the kernel lets real-time threads run without a pause. By default it stops them for 50 ms of each
/// second (kernel.sched_rt_runtime_us = 950000); -1 switches that off.
[[nodiscard]] Grant check_no_throttling(const std::string& path = "/proc/sys/kernel/sched_rt_runtime_us");

/// CPUs of which the calling thread and one that is bound to `cpu` (-1: none) may use any. [-]
[[nodiscard]] int usable_cpus(int cpu = -1);

/// Rights granted to the control thread.
struct RightsReport {
  bool real_time_scheduling{false};  ///< SCHED_FIFO or SCHED_DEADLINE was requested and granted
  bool memory_locked{false};
  int cpu{-1};                          ///< the CPU that it was bound to; -1: none [-]
  std::vector<std::string> refusals{};  ///< one sentence each; empty when everything was granted
};

/// Requests all of the above by the parameters for the calling (control) thread, which wakes every
/// wake_period_ns [ns].
[[nodiscard]] RightsReport set_up_control_thread(const RealtimeParameters& parameters,
                                                 std::int64_t wake_period_ns);

/// Throws std::runtime_error with every refusal where `realtime.required` is set.
void require_rights(const RealtimeParameters& parameters, const RightsReport& rights);

/// Throws std::runtime_error where a thread with these rights would keep everything else from running: one
/// that spins with SCHED_FIFO on the only CPU. `cpus`: how many this process and that thread may use [-].
void require_room_for_spinning(const RealtimeParameters& parameters, const RightsReport& rights, int cpus);
inline void require_room_for_spinning(const RealtimeParameters& parameters, const RightsReport& rights) {
  require_room_for_spinning(parameters, rights, usable_cpus(rights.cpu));
}

}  // namespace sextant
