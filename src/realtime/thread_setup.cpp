#include "sextant/realtime/thread_setup.hpp"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace sextant {
namespace {

Grant refused(const std::string& what, int error, const std::string& remedy) {
  return {false, what + ": " + std::generic_category().message(error) + "; " + remedy};
}

/// The kernel's struct sched_attr (sched_setattr(2)), which glibc does not declare before 2.41.
struct SchedulingAttributes {
  std::uint32_t size;
  std::uint32_t policy;
  std::uint64_t flags;
  std::int32_t nice;
  std::uint32_t priority;
  std::uint64_t runtime;
  std::uint64_t deadline;
  std::uint64_t period;
};

std::string remedy_for_deadline(int error) {
  switch (error) {
    case EBUSY:
      return "the CPUs have no room for it: request less time (realtime.deadline_runtime_us), or allow more "
             "with sysctl kernel.sched_rt_runtime_us";
    case EPERM:
      return "run as root or allow it with CAP_SYS_NICE, and let the process use every CPU (no taskset, no "
             "cpuset)";
    case EINVAL:
      return "the time must be from 1.024 us to the wake period, which must be 100 us or more unless sysctl "
             "kernel.sched_deadline_period_min_us allows less";
    default:
      return "use policy = \"fifo\"";
  }
}

}  // namespace

Grant use_fifo_scheduling(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error == 0) return {true, {}};
  return refused("SCHED_FIFO priority " + std::to_string(priority) + " was refused", error,
                 "run as root, or allow it with CAP_SYS_NICE or an rtprio limit");
}

Grant use_deadline_scheduling(std::int64_t runtime_ns, std::int64_t period_ns) {
  SchedulingAttributes attributes{};
  attributes.size = sizeof attributes;
  attributes.policy = SCHED_DEADLINE;
  attributes.runtime = static_cast<std::uint64_t>(runtime_ns);
  attributes.deadline = attributes.period = static_cast<std::uint64_t>(period_ns);
  if (syscall(SYS_sched_setattr, 0, &attributes, 0U) == 0) return {true, {}};
  const int error = errno;
  return refused("SCHED_DEADLINE with " + std::to_string(runtime_ns / 1'000) + " us in each " +
                     std::to_string(period_ns / 1'000) + " us was refused",
                 error, remedy_for_deadline(error));
}

Grant bind_to_cpu(int cpu) {
  const std::string what = "binding the thread to CPU " + std::to_string(cpu) + " was refused";
  const std::string remedy = "choose a CPU that this machine has and the process may use";
  if (cpu < 0 || cpu >= CPU_SETSIZE) return refused(what, EINVAL, remedy);
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  return error == 0 ? Grant{true, {}} : refused(what, error, remedy);
}

Grant keep_off_cpu(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (cpu < 0 || cpu >= CPU_SETSIZE) return {true, {}};
  int error = pthread_getaffinity_np(pthread_self(), sizeof set, &set);
  CPU_CLR(static_cast<std::size_t>(cpu), &set);
  if (error == 0 && CPU_COUNT(&set) == 0) {
    return {false,
            "no processor is left but CPU " + std::to_string(cpu) +
                ", which the other threads share with the real-time thread; give the process a CPU more"};
  }
  if (error == 0) error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  if (error == 0) return {true, {}};
  return refused("keeping other threads off CPU " + std::to_string(cpu) + " was refused", error,
                 "give the process a CPU more");
}

void reserve_little_memory() {
  constexpr std::size_t stack_bytes = std::size_t{1024} * 1024;
  mallopt(M_ARENA_MAX, 1);
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  // A refusal costs memory only.
  (void)pthread_attr_setstacksize(&attributes, stack_bytes);
  (void)pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

Grant lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    return refused("locking memory was refused", errno,
                   "run as root, or allow it with CAP_IPC_LOCK or a memlock limit");
  }
  // Memory given back to the kernel would have to be faulted in again.
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  return {true, {}};
}

void prefault_heap() {
  constexpr std::size_t size = std::size_t{8} * 1024 * 1024;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::unique_ptr<volatile char[]> block{new volatile char[size]};
  for (std::size_t i = 0; i < size; i += page) block[i] = 0;
}

[[gnu::noinline]] void prefault_stack() noexcept {
  std::array<volatile char, std::size_t{256} * 1024> stack;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (std::size_t i = 0; i < stack.size(); i += page) stack[i] = 0;
}

Grant name_thread(const std::string& name) {
  const int error = pthread_setname_np(pthread_self(), name.c_str());
  if (error == 0) return {true, {}};
  return refused("naming the thread \"" + name + "\" was refused", error, "use at most 15 characters");
}

Grant check_no_throttling(const std::string& path) {
  long runtime_us = 0;
  std::ifstream file{path};
  if (!(file >> runtime_us)) return {false, "real-time throttling is unknown: " + path + " cannot be read"};
  if (runtime_us < 0) return {true, {}};
  return {false, "real-time throttling is on: " + path + " holds " + std::to_string(runtime_us) +
                     "; switch it off with sysctl kernel.sched_rt_runtime_us=-1"};
}

int usable_cpus(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (pthread_getaffinity_np(pthread_self(), sizeof set, &set) != 0) return 0;
  if (cpu >= 0 && cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(cpu), &set);
  return CPU_COUNT(&set);
}

void require_rights(const RealtimeParameters& parameters, const RightsReport& rights) {
  if (!parameters.required || rights.refusals.empty()) return;
  std::string sentence = "realtime.required is set, and not everything is granted";
  const char* separator = ": ";
  for (const std::string& refusal : rights.refusals) {
    sentence += separator + refusal;
    separator = "; ";
  }
  throw std::runtime_error(sentence);
}

void require_room_for_spinning(const RealtimeParameters& parameters, const RightsReport& rights, int cpus) {
  const bool never_sleeps = parameters.wait.mode == WaitMode::spin && rights.real_time_scheduling &&
                            parameters.policy == SchedulingPolicy::fifo;
  if (!never_sleeps || cpus != 1) return;
  throw std::runtime_error(
      "realtime: wait = \"spin\" with policy = \"fifo\" needs a CPU of its own, and the process may use one "
      "CPU "
      "only: no other thread would run; set wait = \"sleep\", or give the process a CPU more");
}

RightsReport set_up_control_thread(const RealtimeParameters& parameters, std::int64_t wake_period_ns) {
  RightsReport report;
  const auto note = [&report](Grant grant) {
    if (!grant.granted) report.refusals.push_back(std::move(grant.sentence));
    return grant.granted;
  };
  if (parameters.lock_memory) report.memory_locked = note(lock_memory());
  prefault_heap();
  prefault_stack();
  if (parameters.cpu >= 0 && note(bind_to_cpu(parameters.cpu))) report.cpu = parameters.cpu;
  if (parameters.policy == SchedulingPolicy::fifo) {
    report.real_time_scheduling = note(use_fifo_scheduling(parameters.priority));
  }
  if (parameters.policy == SchedulingPolicy::deadline) {
    report.real_time_scheduling =
        note(use_deadline_scheduling(parameters.deadline_runtime_ns, wake_period_ns));
  }
  // The kernel throttles SCHED_FIFO only; it accounts for a SCHED_DEADLINE thread when it grants it.
  if (parameters.policy == SchedulingPolicy::fifo) note(check_no_throttling());
  return report;
}

}  // namespace sextant
