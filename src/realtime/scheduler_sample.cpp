#include "sextant/realtime/scheduler_sample.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

bool read_run_delay(const std::string& path, SchedulerSample& sample) {
  std::ifstream file{path};
  std::int64_t on_cpu_ns = 0;
  return bool(file >> on_cpu_ns >> sample.run_delay_ns);
}

bool read_switches(const std::string& path, SchedulerSample& sample) {
  std::ifstream file{path};
  int found = 0;
  std::string key;
  while (file >> key) {
    if (key == "voluntary_ctxt_switches:" && file >> sample.voluntary_switches) ++found;
    if (key == "nonvoluntary_ctxt_switches:" && file >> sample.involuntary_switches) ++found;
  }
  return found == 2;
}

/// Fields 10 and 12, counted behind the name, which may hold spaces and brackets.
bool read_faults(const std::string& path, SchedulerSample& sample) {
  std::ifstream file{path};
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');
  if (name_end == std::string::npos) return false;
  std::istringstream fields{line.substr(name_end + 1)};
  std::string skipped;
  for (int field = 3; field < 10; ++field) fields >> skipped;
  std::uint64_t of_children = 0;
  return bool(fields >> sample.minor_faults >> of_children >> sample.major_faults);
}

/// The eighth number of the line "cpu" [USER_HZ].
bool read_steal(const std::string& path, SchedulerSample& sample) {
  std::ifstream file{path};
  std::string cpu;
  file >> cpu;
  std::int64_t ticks = 0;
  for (int column = 0; column < 8; ++column) file >> ticks;
  sample.steal_ns = ticks * (ns_per_s / sysconf(_SC_CLK_TCK));
  return bool(file) && cpu == "cpu";
}

}  // namespace

SchedulerSample SchedulerSample::since(const SchedulerSample& before) const noexcept {
  return {t_ns,
          run_delay_ns - before.run_delay_ns,
          steal_ns - before.steal_ns,
          voluntary_switches - before.voluntary_switches,
          involuntary_switches - before.involuntary_switches,
          minor_faults - before.minor_faults,
          major_faults - before.major_faults,
          valid};
}

SchedulerSample SchedulerSample::and_left_over(const SchedulerSample& earlier) const noexcept {
  return {t_ns,
          run_delay_ns + earlier.run_delay_ns,
          steal_ns + earlier.steal_ns,
          voluntary_switches + earlier.voluntary_switches,
          involuntary_switches + earlier.involuntary_switches,
          minor_faults + earlier.minor_faults,
          major_faults + earlier.major_faults,
          valid};
}

SchedulerSample SchedulerSample::at_most(const SchedulerSample& limit) const noexcept {
  return {t_ns,
          std::min(run_delay_ns, limit.run_delay_ns),
          std::min(steal_ns, limit.steal_ns),
          std::min(voluntary_switches, limit.voluntary_switches),
          std::min(involuntary_switches, limit.involuntary_switches),
          std::min(minor_faults, limit.minor_faults),
          std::min(major_faults, limit.major_faults),
          valid};
}

SchedulerSampler::SchedulerSampler(int thread_id, const std::string& root)
    : task_{root + "/self/task/" + std::to_string(thread_id)}, machine_{root + "/stat"} {}

SchedulerSample SchedulerSampler::sample() const {
  SchedulerSample sample;
  sample.t_ns = now_ns();
  sample.valid = read_run_delay(task_ + "/schedstat", sample) && read_switches(task_ + "/status", sample) &&
                 read_faults(task_ + "/stat", sample) && read_steal(machine_, sample);
  return sample;
}

}  // namespace sextant
