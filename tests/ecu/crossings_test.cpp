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

}  // namespace
}  // namespace sextant::ecu
