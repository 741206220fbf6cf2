#pragma once

#include <string>
#include <vector>

#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {

/// What came of asking the operating system for something. Nothing here throws: the program decides by
/// `RealtimeParameters::required` whether a refusal ends it.
struct Grant {
  bool granted{false};
  std::string sentence{};  ///< empty when granted, else what was refused, why, and what helps
};

/// SCHED_FIFO for the calling thread, so that no ordinary thread delays it. Priority 1…99.
[[nodiscard]] Grant use_fifo_scheduling(int priority);

/// Binds the calling thread to one CPU, so that it neither migrates nor finds cold caches.
[[nodiscard]] Grant bind_to_cpu(int cpu);

/// Keeps all present and future memory of the process resident, and freed heap memory in the process.
[[nodiscard]] Grant lock_memory();

/// Touches the next 256 KiB of the calling thread's stack, so that their page faults happen now.
void prefault_stack() noexcept;

/// Names the calling thread for `ps`, `top` and traces; at most 15 characters.
[[nodiscard]] Grant name_thread(const std::string& name);

/// Whether the kernel lets real-time threads run without a pause. By default it stops them for 50 ms of each
/// second (kernel.sched_rt_runtime_us = 950000); -1 switches that off.
[[nodiscard]] Grant check_no_throttling(const std::string& path = "/proc/sys/kernel/sched_rt_runtime_us");

/// What the control thread was given.
struct RightsReport {
  bool fifo_scheduling{false};
  bool memory_locked{false};
  std::vector<std::string> refusals{};  ///< one sentence each; empty when everything was granted
};

/// All of the above as the parameters ask, for the calling (control) thread.
[[nodiscard]] RightsReport set_up_control_thread(const RealtimeParameters& parameters);

}  // namespace sextant
