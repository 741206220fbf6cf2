#include "sextant/realtime/thread_setup.hpp"

#include <array>
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <system_error>
#include <utility>

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

namespace sextant {
namespace {

Grant refused(const std::string& what, int error, const std::string& remedy) {
  return {false, what + ": " + std::generic_category().message(error) + "; " + remedy};
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

RightsReport set_up_control_thread(const RealtimeParameters& parameters) {
  RightsReport report;
  const auto note = [&report](Grant grant) {
    if (!grant.granted) report.refusals.push_back(std::move(grant.sentence));
    return grant.granted;
  };
  if (parameters.lock_memory) report.memory_locked = note(lock_memory());
  prefault_stack();
  if (parameters.cpu >= 0) note(bind_to_cpu(parameters.cpu));
  report.fifo_scheduling = note(use_fifo_scheduling(parameters.priority));
  note(check_no_throttling());
  return report;
}

}  // namespace sextant
