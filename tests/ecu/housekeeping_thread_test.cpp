#include <atomic>
#include <chrono>
#include <string>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "ecu/eventually.hpp"
#include "ecu/polled_task.hpp"
#include "ecu/tasks/housekeeping_task.hpp"

namespace sextant::ecu {
namespace {

TEST(HousekeepingTask, TellsWhatBecameOfAnotherThreadSinceItsStart) {
  constexpr std::size_t pages = 64;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* const memory =
      mmap(nullptr, pages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(madvise(memory, pages * page, MADV_NOHUGEPAGE), 0);
  SharedState shared{25'000, 1};
  shared.control_thread_id.store(gettid());
  HousekeepingTask task{shared};
  test::PolledTask housekeeping{shared, [&] { task.poll(); }, [&] { task.start(); },
                                std::chrono::milliseconds{HousekeepingTask::poll_every_ms}};
  housekeeping.start();
  ASSERT_TRUE(test::eventually([&] { return shared.scheduler.update(); }));
  const SchedulerSample before = shared.scheduler.value();
  EXPECT_TRUE(before.valid);
  for (std::size_t i = 0; i < pages; ++i) static_cast<volatile char*>(memory)[i * page] = 1;
  EXPECT_TRUE(test::eventually(
      [&] { return shared.scheduler.latest().minor_faults >= before.minor_faults + pages; }));
  EXPECT_GT(shared.scheduler.value().voluntary_switches, before.voluntary_switches)
      << "this thread has slept";
  EXPECT_LT(shared.scheduler.value().minor_faults, 100'000U) << "counted from its start";
  housekeeping.stop();
  munmap(memory, pages * page);
}

TEST(HousekeepingTask, WarnsOnceOfATelemetryThreadThatStopped) {
  SharedState shared{25'000, 1};
  shared.control_thread_id.store(gettid());
  shared.telemetry_polls.store(1);
  std::atomic<int> warnings{0};
  HousekeepingTask task{shared, [&](const std::string&) { ++warnings; }};
  test::PolledTask housekeeping{shared, [&] { task.poll(); }, [&] { task.start(); },
                                std::chrono::milliseconds{HousekeepingTask::poll_every_ms}};
  housekeeping.start();
  EXPECT_TRUE(test::eventually([&] { return shared.telemetry_stalls.load() == 1; }));
  EXPECT_TRUE(test::eventually([&] { return warnings == 1; }));
  shared.telemetry_polls.store(2);
  EXPECT_TRUE(test::eventually([&] { return warnings == 2; })) << "it runs again";
  housekeeping.stop();
  EXPECT_EQ(shared.telemetry_stalls.load(), 1U);
}

TEST(HousekeepingTask, AWatchdogThatHasStoppedIsAFault) {
  SharedState shared{25'000, 1};
  shared.control_thread_id.store(gettid());
  std::atomic<int> warnings{0};
  HousekeepingTask task{shared, [&](const std::string&) { ++warnings; }};
  test::PolledTask housekeeping{shared, [&] { task.poll(); }, [&] { task.start(); },
                                std::chrono::milliseconds{HousekeepingTask::poll_every_ms}};
  housekeeping.start();
  ASSERT_TRUE(test::eventually([&] { return shared.housekeeping_polls.load() > 100; }));
  EXPECT_FALSE(shared.watchdog_stopped.load()) << "none has started";
  shared.watchdog_polls.store(1);
  EXPECT_TRUE(test::eventually([&] { return shared.watchdog_stopped.load(); }));
  EXPECT_TRUE(test::eventually([&] { return warnings == 1; }));
  shared.watchdog_polls.store(2);
  EXPECT_TRUE(test::eventually([&] { return !shared.watchdog_stopped.load() && warnings == 2; }));
  housekeeping.stop();
  EXPECT_EQ(shared.telemetry_stalls.load(), 0U);
}

}  // namespace
}  // namespace sextant::ecu
