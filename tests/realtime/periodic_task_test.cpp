#include "sextant/realtime/periodic_task.hpp"

#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/resource.h>

namespace sextant {
namespace {

TEST(PeriodicTask, NeverWakesBeforeADeadlineAndStaysOnTheGrid) {
  const WakeSchedule::Parameters parameters{50'000, 4};
  PeriodicTask task{parameters};
  const std::int64_t origin_ns = task.start();
  for (int i = 0; i < 50; ++i) {
    const WakeSchedule::Wake wake = task.wait();
    EXPECT_GE(now_ns(), wake.deadline_ns);
    EXPECT_EQ((wake.deadline_ns - origin_ns) % parameters.wake_period_ns(), 0);
  }
}

TEST(PeriodicTask, TellsItsDeadlinesApartFromTheKernelsTicks) {
  constexpr std::int64_t lead_ns = 6'000;
  PeriodicTask task{{50'000, 1}, {.mode = WaitMode::spin, .tick_lead_ns = lead_ns}};
  task.start();
  for (int i = 0; i < 20; ++i) EXPECT_EQ((task.wait().deadline_ns + lead_ns) % 50'000, 0);
}

TEST(PeriodicTask, AStallIsOneOverrun) {
  const WakeSchedule::Parameters parameters{50'000, 2};
  PeriodicTask task{parameters};
  const std::int64_t origin_ns = task.start();
  task.wait();
  const std::uint64_t overruns_before = task.schedule().counters().overruns;
  std::this_thread::sleep_for(std::chrono::milliseconds{2});
  const WakeSchedule::Wake wake = task.wait();
  EXPECT_TRUE(wake.overrun());
  EXPECT_GE(wake.periods_missed, 38) << "2 ms are twenty wake periods, at least the last of which is served";
  EXPECT_EQ(task.schedule().counters().overruns, overruns_before + 1);
  EXPECT_EQ((wake.deadline_ns - origin_ns) % parameters.wake_period_ns(), 0);
}

TEST(PeriodicTask, NeverWakesBeforeADeadlineHoweverItWaits) {
  for (const WaitMode mode : {WaitMode::sleep, WaitMode::spin, WaitMode::hybrid}) {
    SCOPED_TRACE(to_string(mode));
    const WakeSchedule::Parameters parameters{250'000, 4};
    PeriodicTask task{parameters, {.mode = mode, .spin_margin_ns = 200'000}};
    const std::int64_t origin_ns = task.start();
    for (int i = 0; i < 20; ++i) {
      const WakeSchedule::Wake wake = task.wait();
      EXPECT_GE(task.woken_ns(), wake.deadline_ns);
      EXPECT_LE(task.began_ns(), task.woken_ns());
      EXPECT_EQ((wake.deadline_ns - origin_ns) % parameters.wake_period_ns(), 0);
    }
  }
}

/// How often the calling thread has given the processor away. [-]
long times_slept() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nvcsw;
}

/// Calls `attempt` until it says that the machine did not disturb it, at most 50 times.
bool undisturbed(const std::function<bool()>& attempt) {
  for (int i = 0; i < 50; ++i)
    if (attempt()) return true;
  return false;
}

TEST(PeriodicTask, SleepsAndSpinsAsItIsTold) {
  const struct {
    WaitMode mode;
    long sleeps;
    bool spins;
  } cases[] = {{WaitMode::sleep, 1, false}, {WaitMode::spin, 0, true}, {WaitMode::hybrid, 1, true}};
  constexpr std::int64_t margin_ns = 20'000'000;
  for (const auto& expected : cases) {
    SCOPED_TRACE(to_string(expected.mode));
    EXPECT_TRUE(undisturbed([&] {
      PeriodicTask task{{40'000'000, 1}, {.mode = expected.mode, .spin_margin_ns = margin_ns}};
      task.start();
      const long before = times_slept();
      const std::int64_t entered_ns = now_ns();
      const WakeSchedule::Wake wake = task.wait();
      if (entered_ns > wake.deadline_ns - margin_ns || wake.periods_missed > 0) return false;
      EXPECT_EQ(times_slept() - before, expected.sleeps);
      EXPECT_EQ(task.longest_gap_ns() > 0, expected.spins);
      return true;
    }));
  }
}

constexpr std::int64_t stop_ns = 3'000'000;
volatile std::sig_atomic_t stopped = 0;
std::int64_t stop_began_ns = 0;  // written by the handler on the thread that reads it

// A signal handler stands for whatever else takes the processor away.
void stop_the_thread(int) {
  stop_began_ns = now_ns();
  while (now_ns() - stop_began_ns < stop_ns) {
  }
  stopped = 1;
}

TEST(PeriodicTask, SeesThatItWasStoppedWhileItSpun) {
  struct sigaction action{};
  action.sa_handler = stop_the_thread;
  ASSERT_EQ(sigaction(SIGUSR1, &action, nullptr), 0);
  EXPECT_TRUE(undisturbed([] {
    stopped = 0;
    PeriodicTask task{{50'000'000, 1}, {.mode = WaitMode::spin}};
    const pthread_t self = pthread_self();
    std::thread other{[self] {
      std::this_thread::sleep_for(std::chrono::milliseconds{10});
      pthread_kill(self, SIGUSR1);
    }};
    task.start();
    const std::int64_t entered_ns = now_ns();
    const WakeSchedule::Wake wake = task.wait();
    other.join();
    const bool while_it_spun =
        stopped && stop_began_ns > entered_ns && stop_began_ns + stop_ns < wake.deadline_ns;
    if (!while_it_spun) return false;
    EXPECT_GE(task.longest_gap_ns(), stop_ns);
    EXPECT_LT(task.longest_gap_ns(), 50'000'000 + wake.latency_ns);
    return true;
  }));
}

}  // namespace
}  // namespace sextant
