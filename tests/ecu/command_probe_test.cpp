#include "ecu/command_probe.hpp"

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
  probe.see(command(1, 1'000'000'000));
  probe.written();
  const std::int64_t way_ns = probe.take();
  EXPECT_GE(way_ns, 1'000'000'000);
  EXPECT_LT(way_ns, 11'000'000'000);
}

TEST(CommandProbe, OnlyTheFirstPatternCounts) {
  CommandProbe probe;
  const TorqueCommand<double> c = command(1, 0);
  probe.see(c);
  probe.written();
  EXPECT_GT(probe.take(), 0);
  probe.see(c);
  probe.written();
  EXPECT_EQ(probe.take(), 0) << "the pattern before has shown it already";
}

TEST(CommandProbe, WithoutACommandThereIsNothing) {
  CommandProbe probe;
  probe.see(TorqueCommand<double>{});
  probe.written();
  EXPECT_EQ(probe.take(), 0);
}

TEST(CommandProbe, OfSeveralCommandsInAWakeUpTheLongestWayIsKept) {
  CommandProbe probe;
  probe.see(command(1, 2'000'000'000));
  probe.written();
  probe.see(command(2, 0));
  probe.written();
  EXPECT_GE(probe.take(), 2'000'000'000);
}

}  // namespace
}  // namespace sextant::ecu
