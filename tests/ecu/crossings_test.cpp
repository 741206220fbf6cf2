#include "ecu/crossings.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

// A telemetry thread that is held up for a second must find every record, however often the control thread
// wakes.
TEST(Crossings, TheRingsHoldASecond) {
  for (const std::int32_t period_ns : {5'000, 25'000, 62'500}) {
    for (const int wake_every_periods : {1, 40}) {
      Crossings crossings{period_ns, wake_every_periods};
      const std::int64_t periods = 1'000'000'000 / period_ns;
      for (std::int64_t k = 0; k < periods; ++k) {
        crossings.telemetry.push({});
        if (k % wake_every_periods == 0) crossings.wakes.push({});
      }
      EXPECT_EQ(crossings.telemetry.dropped(), 0U);
      EXPECT_EQ(crossings.wakes.dropped(), 0U) << period_ns << " ns, " << wake_every_periods << " a wake-up";
    }
  }
}

TEST(Crossings, AnAbsenceIsOrderedOffByTheBeatThatEndsIt) {
  constexpr std::int64_t limit_ns = 5'000'000;
  Crossings crossings{25'000, 1, limit_ns};
  crossings.beat(50 * limit_ns);
  EXPECT_FALSE(crossings.gates_disabled.load()) << "nothing was there before the first beat";
  crossings.beat(51 * limit_ns);
  EXPECT_FALSE(crossings.gates_disabled.load());
  crossings.beat(52 * limit_ns + 1);
  EXPECT_TRUE(crossings.gates_disabled.load());
  EXPECT_EQ(crossings.heartbeat_ns.load(), 52 * limit_ns + 1);
  crossings.beat(53 * limit_ns);
  EXPECT_TRUE(crossings.gates_disabled.load()) << "only who reads the order takes it";
}

}  // namespace
}  // namespace sextant::ecu
