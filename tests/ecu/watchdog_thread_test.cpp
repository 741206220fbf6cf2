#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include "ecu/eventually.hpp"
#include "ecu/polled_task.hpp"
#include "ecu/tasks/control_task.hpp"
#include "ecu/tasks/watchdog_task.hpp"
#include "ecu/threads/watchdog_rights.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t limit_ns = 60 * ns_per_s;  // no machine is held up for so long

class WatchdogThreadTest : public testing::Test {
 protected:
  void TearDown() override { watchdog.stop(); }

  SharedState shared{25'000, 40, limit_ns};
  SharedCommands commands{shared};
  std::atomic<int> opened{0};
  WatchdogTask task{shared, [this] { ++opened; }};
  test::PolledTask watchdog{shared, [this] { task.poll(now_ns()); }};
};

TEST_F(WatchdogThreadTest, ItsOrderStandsUntilTheDriveHasSeenItOnce) {
  shared.heartbeat_ns.store(now_ns() - 2 * limit_ns);
  watchdog.start();
  ASSERT_TRUE(test::eventually([this] { return shared.gate_inhibit.load(); }));
  shared.heartbeat_ns.store(now_ns());  // the control thread is back
  std::this_thread::sleep_for(30ms);    // many polls of the watchdog
  EXPECT_TRUE(commands.latest(0).external.test(Fault::watchdog));
  EXPECT_FALSE(commands.latest(0).external.any());
}

// There is no control thread here, as when it hangs: the watchdog acts without it.
TEST_F(WatchdogThreadTest, TakesTheGateEnableLineAwayItselfForAsLongAsTheControlThreadHangs) {
  shared.heartbeat_ns.store(now_ns() - 2 * limit_ns);
  watchdog.start();
  ASSERT_TRUE(test::eventually([this] { return opened.load() >= 3; }));
  shared.heartbeat_ns.store(now_ns());
  // A poll that had begun before may still end late; then the count stands.
  EXPECT_TRUE(test::eventually([this] {
    const int before = opened.load();
    std::this_thread::sleep_for(30ms);
    return opened.load() == before;
  }));
}

TEST_F(WatchdogThreadTest, KeepsStillWhileTheControlThreadBeats) {
  shared.heartbeat_ns.store(now_ns());
  watchdog.start();
  std::this_thread::sleep_for(30ms);
  EXPECT_EQ(opened.load(), 0);
  EXPECT_FALSE(commands.latest(0).external.any());
}

TEST_F(WatchdogThreadTest, CountsItsPolls) {
  EXPECT_EQ(shared.watchdog_polls.load(), 0U);
  watchdog.start();
  EXPECT_TRUE(test::eventually([this] { return shared.watchdog_polls.load() >= 3; }));
}

TEST_F(WatchdogThreadTest, KeepsStillBeforeTheFirstHeartbeat) {
  watchdog.start();
  std::this_thread::sleep_for(30ms);
  EXPECT_FALSE(commands.latest(0).external.any());
}

/// The SCHED_FIFO priority of the calling thread; 0 without.
int fifo_priority() {
  int policy = 0;
  sched_param parameters{};
  if (pthread_getschedparam(pthread_self(), &policy, &parameters) != 0 || policy != SCHED_FIFO) return 0;
  return parameters.sched_priority;
}

/// What a thread gets that asks for it.
int granted_priority(int priority) {
  bool granted = false;
  std::thread{[&] { granted = use_fifo_scheduling(priority).granted; }}.join();
  return granted ? priority : 0;
}

TEST(WatchdogPriority, IsAboveTheControlThreadWhereThatIsRealTime) {
  for (const int control_priority : {0, 80}) {
    SharedState shared{250'000, 1, 1};
    std::atomic<int> priority{-1};
    WatchdogTask task{shared, [&] { priority = fifo_priority(); }};
    test::PolledTask watchdog{shared, [&] { task.poll(now_ns()); },
                              [&] { request_watchdog_priority(control_priority); }};
    shared.heartbeat_ns.store(1);
    watchdog.start();
    EXPECT_TRUE(test::eventually([&] { return priority.load() >= 0; }));
    watchdog.stop();
    const int highest = granted_priority(watchdog_priority);
    const int wanted = highest > 0 ? highest : granted_priority(control_priority);
    EXPECT_EQ(priority.load(), control_priority == 0 ? 0 : wanted);
  }
}

}  // namespace
}  // namespace sextant::ecu
