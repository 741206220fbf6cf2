// The control thread tells its rights through a promise. Whoever waits may go on before the thread has
// returned from setting the value; what the promise consists of has to be there until then.

#include <atomic>
#include <chrono>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <thread>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <linux/futex.h>
#include <sys/syscall.h>

#include "ecu/threads/control_thread.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace {

std::atomic<bool> watched{false};
std::atomic<std::uintptr_t> setting{0};  // where the word lies whose waiters a thread wakes; 0: none does
std::atomic<bool> has_waited{false};     // a waiter was woken
std::atomic<bool> freed_while_setting{false};

}  // namespace

/// The standard library wakes those who wait for a value by this function. The setter comes back from it
/// late.
extern "C" long syscall(long number, ...) noexcept {
  using Call = long(long, long, long, long, long, long, long);
  static auto* const real = reinterpret_cast<Call*>(dlsym(RTLD_NEXT, "syscall"));
  std::va_list list;
  va_start(list, number);
  long a[6];
  for (long& x : a) x = va_arg(list, long);
  va_end(list);
  const bool wakes = number == SYS_futex && (a[1] & FUTEX_CMD_MASK) == FUTEX_WAKE && watched.load();
  if (wakes) setting.store(static_cast<std::uintptr_t>(a[0]));
  const long result = real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
  if (wakes) {
    std::this_thread::sleep_for(std::chrono::milliseconds{200});
    setting.store(0);
    has_waited.store(true);
  }
  return result;
}

void* operator new(std::size_t size) {
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc{};
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t size) noexcept {
  const std::uintptr_t word = setting.load();
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  if (word >= begin && word < begin + size) freed_while_setting.store(true);
  std::free(memory);
}

namespace sextant::ecu {
namespace {

constexpr std::int32_t period_ns = 25'000;

TEST(RightsHandover, WhatTheThreadSetsIsThereUntilItHasSetIt) {
  // Where the thread has answered before anybody waits, nobody is woken.
  for (int n = 0; n < 100 && !has_waited.load(); ++n) {
    SharedState shared{period_ns, 40};
    SimulatedPowerStage stage{{.integrator = IntegratorKind::fixed}, {}};
    DirectTorqueController<double> controller{{}};
    Drive<double> drive{{}, controller};
    ControlTask task{{.period_ns = period_ns, .wake_every_periods = 40}, drive, shared};
    ControlThread control{{.lock_memory = false}, stage.io(), task, shared};
    watched.store(true);
    (void)control.start();
    shared.shutdown.store(true);
    control.join();
    watched.store(false);
  }
  ASSERT_TRUE(has_waited.load()) << "the standard library wakes in another way";
  EXPECT_FALSE(freed_while_setting.load());
}

}  // namespace
}  // namespace sextant::ecu
