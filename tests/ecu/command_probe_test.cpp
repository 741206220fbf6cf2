#include "ecu/timing/command_probe.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

TorqueCommand<double> command(std::uint32_t sequence, std::int64_t age_ns) {
  TorqueCommand<double> c;
  c.sequence = sequence;
  c.received_ns = now_ns() - age_ns;
  return c;
}

TEST(CommandProbe, ACommandIsTimedFromItsArrivalToTheFirstPattern) {
  CommandProbe probe;
  probe.add(command(1, 1'000'000'000));
  probe.written();
  const std::int64_t way_ns = probe.take_longest_ns();
  EXPECT_GE(way_ns, 1'000'000'000);
  EXPECT_LT(way_ns, 11'000'000'000);
}

TEST(CommandProbe, OnlyTheFirstPatternCounts) {
  CommandProbe probe;
  const TorqueCommand<double> c = command(1, 0);
  probe.add(c);
  probe.written();
  EXPECT_GT(probe.take_longest_ns(), 0);
  probe.add(c);
  probe.written();
  EXPECT_EQ(probe.take_longest_ns(), 0) << "the pattern before has shown it already";
}

TEST(CommandProbe, WithoutACommandThereIsNothing) {
  CommandProbe probe;
  probe.add(TorqueCommand<double>{});
  probe.written();
  EXPECT_EQ(probe.take_longest_ns(), 0);
}

TEST(CommandProbe, OfSeveralCommandsInAWakeUpTheLongestWayIsKept) {
  CommandProbe probe;
  probe.add(command(1, 2'000'000'000));
  probe.written();
  probe.add(command(2, 0));
  probe.written();
  EXPECT_GE(probe.take_longest_ns(), 2'000'000'000);
}

}  // namespace
}  // namespace sextant::ecu
