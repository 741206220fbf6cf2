#pragma once

#include <ctime>

namespace sextant::bench {

/// CPU time of the whole process, its helper threads included. On a shared machine it says more than the wall
/// clock. [ns]
inline double process_cpu_ns() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) * 1e9 + double(now.tv_nsec);
}

}  // namespace sextant::bench
