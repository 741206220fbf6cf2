#include "ecu/tasks/shared_commands.hpp"

#include <gtest/gtest.h>

#include "ecu/fake_can_bus.hpp"
#include "ecu/tasks/transmit_task.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(SharedCommands, ThreeOverrunsInARowAreAFaultUntilAWakeUpInTime) {
  SharedState shared{25'000, 40};
  SharedCommands commands{shared};
  for (const std::uint32_t in_a_row : {0U, 1U, 2U}) {
    commands.note_overruns(in_a_row);
    EXPECT_FALSE(commands.latest(ms).external.any()) << in_a_row;
  }
  for (const std::uint32_t in_a_row : {3U, 4U}) {
    commands.note_overruns(in_a_row);
    EXPECT_TRUE(commands.latest(ms).external.test(Fault::overrun)) << in_a_row;
  }
  commands.note_overruns(0);
  EXPECT_FALSE(commands.latest(ms).external.any());
}

TEST(SharedCommands, TheLimitOfOverrunsIsConfigured) {
  SharedState shared{25'000, 40};
  SharedCommands commands{shared, 5};
  commands.note_overruns(4);
  EXPECT_FALSE(commands.latest(ms).external.any());
  commands.note_overruns(5);
  EXPECT_TRUE(commands.latest(ms).external.test(Fault::overrun));
}

TEST(SharedCommands, AWatchdogThatHasStoppedIsAFaultUntilItRunsAgain) {
  SharedState shared{25'000, 40};
  SharedCommands commands{shared};
  EXPECT_FALSE(commands.latest(ms).external.any());
  shared.watchdog_stopped.store(true);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(commands.latest(ms).external.test(Fault::watchdog));
  shared.watchdog_stopped.store(false);
  EXPECT_FALSE(commands.latest(ms).external.any());
}

TEST(SharedCommands, TheAgeOfTheStatusCountsFromTheLastFrameThatWasSent) {
  SharedState shared{25'000, 40};
  SharedCommands commands{shared};
  EXPECT_EQ(commands.latest(10'000 * ms).status_age_ns, 0) << "nothing is to be sent yet";
  test::FakeCanBus bus;
  TransmitTask transmit{bus, shared};
  transmit.start(100 * ms);
  EXPECT_EQ(commands.latest(110 * ms).status_age_ns, 10 * ms) << "from the start on, without a poll";
  bus.answer(CanSend::no_buffer);
  for (std::int64_t t = 115 * ms; t <= 150 * ms; t += 5 * ms) transmit.poll(t);
  EXPECT_EQ(commands.latest(150 * ms).status_age_ns, 50 * ms) << "none was sent";
  bus.answer(CanSend::ok);
  for (std::int64_t t = 155 * ms; t <= 200 * ms; t += 5 * ms) transmit.poll(t);
  EXPECT_LE(commands.latest(200 * ms).status_age_ns, 10 * ms);
  bus.answer(CanSend::down);
  for (std::int64_t t = 205 * ms; t <= 400 * ms; t += 5 * ms) transmit.poll(t);
  EXPECT_GE(commands.latest(400 * ms).status_age_ns, 195 * ms);
}

}  // namespace
}  // namespace sextant::ecu
