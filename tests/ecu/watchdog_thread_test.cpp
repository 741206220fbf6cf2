#include "ecu/watchdog_thread.hpp"

#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "ecu/control_thread.hpp"
#include "ecu/eventually.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t limit_ns = 60 * ns_per_s;  // no machine is held up for so long

class WatchdogThreadTest : public testing::Test {
 protected:
  void TearDown() override {
    crossings.stopped.store(true);
    watchdog.join();
  }

  Crossings crossings{25'000, 40};
  LiveCommands commands{crossings};
  std::atomic<int> opened{0};
  WatchdogThread watchdog{limit_ns, crossings, [this] { ++opened; }};
};

TEST_F(WatchdogThreadTest, ItsOrderStandsUntilTheDriveHasSeenItOnce) {
  crossings.heartbeat_ns.store(now_ns() - 2 * limit_ns);
  watchdog.start();
  ASSERT_TRUE(test::eventually([this] { return crossings.gates_disabled.load(); }));
  crossings.heartbeat_ns.store(now_ns());  // the control thread is back
  std::this_thread::sleep_for(30ms);       // many looks of the watchdog
  EXPECT_TRUE(commands.latest(0).external.test(Fault::watchdog));
  EXPECT_FALSE(commands.latest(0).external.any());
}

// Nothing here stands for the control thread: it hangs, and the gates open all the same.
TEST_F(WatchdogThreadTest, TakesTheGateEnableLineAwayItselfForAsLongAsTheControlThreadHangs) {
  crossings.heartbeat_ns.store(now_ns() - 2 * limit_ns);
  watchdog.start();
  ASSERT_TRUE(test::eventually([this] { return opened.load() >= 3; }));
  crossings.heartbeat_ns.store(now_ns());
  // A look that had begun before may still end late; then the count stands.
  EXPECT_TRUE(test::eventually([this] {
    const int before = opened.load();
    std::this_thread::sleep_for(30ms);
    return opened.load() == before;
  }));
}

TEST_F(WatchdogThreadTest, KeepsStillWhileTheControlThreadBeats) {
  crossings.heartbeat_ns.store(now_ns());
  watchdog.start();
  std::this_thread::sleep_for(30ms);
  EXPECT_EQ(opened.load(), 0);
  EXPECT_FALSE(commands.latest(0).external.any());
}

TEST_F(WatchdogThreadTest, KeepsStillBeforeTheFirstHeartbeat) {
  watchdog.start();
  std::this_thread::sleep_for(30ms);
  EXPECT_FALSE(commands.latest(0).external.any());
}

}  // namespace
}  // namespace sextant::ecu
