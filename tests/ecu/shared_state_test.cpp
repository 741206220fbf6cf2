#include "ecu/shared/shared_state.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

// A telemetry thread that is held up for a second must find every record, however often the control thread
// wakes.
TEST(SharedState, TheRingsHoldASecond) {
  for (const std::int32_t period_ns : {5'000, 25'000, 62'500}) {
    for (const int wake_every_periods : {1, 40}) {
      SharedState shared{period_ns, wake_every_periods};
      const std::int64_t periods = 1'000'000'000 / period_ns;
      for (std::int64_t k = 0; k < periods; ++k) {
        shared.telemetry.push({});
        if (k % wake_every_periods == 0) shared.wakes.push({});
      }
      EXPECT_EQ(shared.telemetry.dropped(), 0U);
      EXPECT_EQ(shared.wakes.dropped(), 0U) << period_ns << " ns, " << wake_every_periods << " a wake-up";
    }
  }
}

TEST(SharedState, AnAbsenceInhibitsTheGatesByTheBeatThatEndsIt) {
  constexpr std::int64_t limit_ns = 5'000'000;
  SharedState shared{25'000, 1, limit_ns};
  shared.beat(50 * limit_ns);
  EXPECT_FALSE(shared.gate_inhibit.load()) << "nothing was there before the first beat";
  shared.beat(51 * limit_ns);
  EXPECT_FALSE(shared.gate_inhibit.load());
  shared.beat(52 * limit_ns + 1);
  EXPECT_TRUE(shared.gate_inhibit.load());
  EXPECT_EQ(shared.heartbeat_ns.load(), 52 * limit_ns + 1);
  shared.beat(53 * limit_ns);
  EXPECT_TRUE(shared.gate_inhibit.load()) << "only who reads the order takes it";
}

}  // namespace
}  // namespace sextant::ecu
