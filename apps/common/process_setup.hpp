#pragma once

#include <string>

#include <spdlog/spdlog.h>

#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant {

/// What every thread and child process inherits, so before the first of them: the memory that a thread may
/// reserve, and all CPUs but the one of the real-time thread. A refusal is logged.
inline void set_up_process(const RealtimeParameters& realtime) {
  if (realtime.lock_memory) reserve_little_memory();
  if (const Grant grant = keep_off_cpu(realtime.cpu); !grant.granted) {
    spdlog::warn("real time: {}", grant.sentence);
  }
}

/// What the real-time thread was given: refusals are logged. Throws std::runtime_error with one sentence
/// where the configuration requires what was refused, or where the thread would leave no processor to the
/// others.
inline void check_rights(const RealtimeParameters& realtime, const RightsReport& rights) {
  require_rights(realtime, rights);
  for (const std::string& sentence : rights.refusals) spdlog::warn("real time: {}", sentence);
  require_room_for_spinning(realtime, rights);
}

}  // namespace sextant
