#include "ecu/housekeeping_thread.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "ecu/eventually.hpp"

namespace sextant::ecu {
namespace {

TEST(HousekeepingThread, TellsWhatBecameOfAnotherThreadSinceItsStart) {
  constexpr std::size_t pages = 64;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* const memory =
      mmap(nullptr, pages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(madvise(memory, pages * page, MADV_NOHUGEPAGE), 0);
  Crossings crossings{25'000, 1};
  crossings.control_thread_id.store(gettid());
  HousekeepingThread housekeeping{crossings};
  housekeeping.start();
  ASSERT_TRUE(test::eventually([&] { return crossings.scheduler.update(); }));
  const SchedulerSample before = crossings.scheduler.value();
  EXPECT_TRUE(before.valid);
  for (std::size_t i = 0; i < pages; ++i) static_cast<volatile char*>(memory)[i * page] = 1;
  EXPECT_TRUE(test::eventually(
      [&] { return crossings.scheduler.latest().minor_faults >= before.minor_faults + pages; }));
  EXPECT_GT(crossings.scheduler.value().voluntary_switches, before.voluntary_switches)
      << "this thread has slept";
  EXPECT_LT(crossings.scheduler.value().minor_faults, 100'000U) << "counted from its start";
  crossings.stopped.store(true);
  housekeeping.join();
  munmap(memory, pages * page);
}

}  // namespace
}  // namespace sextant::ecu
