#include "sextant/virtual_time/virtual_can_bus.hpp"

#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr std::int64_t ms = 1'000'000;  // [ns]

class VirtualCanBusTest : public ::testing::Test {
 protected:
  VirtualCanBusTest() { timeline.add(bus.party()); }

  /// A frame that can be told from others by its first byte.
  static CanFrame frame(std::uint8_t number) { return {.id = 0x110, .length = 8, .data = {number}}; }

  /// Puts frames 1, 2, 3, … on the bus at 10, 20, 30 ms, …
  void put(int count) {
    for (int n = 1; n <= count; ++n) {
      timeline.run_until(n * 10 * ms);
      bus.put(frame(std::uint8_t(n)));
    }
  }
  /// What arrives from now on up to t_ns: number and time in ms.
  std::vector<std::pair<int, double>> arrivals(std::int64_t t_ns) {
    std::vector<std::pair<int, double>> seen;
    collect(seen);
    while (bus.next_arrival_ns() <= t_ns) {
      timeline.run_until(bus.next_arrival_ns());
      collect(seen);
    }
    timeline.run_until(t_ns);
    return seen;
  }
  void collect(std::vector<std::pair<int, double>>& seen) {
    CanFrame x;
    while (bus.receive(x, {}) == CanReceive::got) {
      seen.emplace_back(x.error ? -1 : x.data[0], double(x.received_ns) / ms);
    }
  }

  VirtualClock clock{};
  VirtualCanBus bus{clock};
  VirtualTimeline timeline{clock};
};

// Each costs the same, however many wait: were it not so, this would take longer than any test may.
TEST_F(VirtualCanBusTest, AMillionFramesArriveAtOneInstant) {
  constexpr int count = 1'000'000;
  for (int n = 0; n < count; ++n) bus.put(frame(std::uint8_t(n)));
  CanFrame x;
  for (int n = 0; n < count; ++n) {
    ASSERT_EQ(bus.receive(x, {}), CanReceive::got);
    ASSERT_EQ(x.data[0], std::uint8_t(n));
  }
  EXPECT_EQ(bus.receive(x, {}), CanReceive::timeout);
}

TEST_F(VirtualCanBusTest, FramesArriveWhenTheyArePutAndInThatOrder) {
  put(2);
  bus.put(frame(3));
  EXPECT_EQ(bus.next_arrival_ns(), 10 * ms);
  EXPECT_THAT(arrivals(50 * ms), ElementsAre(Pair(1, 10), Pair(2, 20), Pair(3, 20)));
  CanFrame none;
  EXPECT_EQ(bus.receive(none, std::chrono::hours{1}), CanReceive::timeout);
}

TEST_F(VirtualCanBusTest, LosesSoManyFramesAndNoMore) {
  bus.add({.kind = BusEventKind::lose, .begin_ns = 20 * ms, .count = 2});
  put(5);
  EXPECT_THAT(arrivals(60 * ms), ElementsAre(Pair(1, 10), Pair(4, 40), Pair(5, 50)));
  EXPECT_EQ(bus.counts().lost, 2U);
}

TEST_F(VirtualCanBusTest, AWindowActsFromItsBeginningToBeforeItsEnd) {
  bus.add({.kind = BusEventKind::lose, .begin_ns = 20 * ms, .end_ns = 40 * ms});
  put(5);
  EXPECT_THAT(arrivals(60 * ms), ElementsAre(Pair(1, 10), Pair(4, 40), Pair(5, 50)));
}

TEST_F(VirtualCanBusTest, CorruptsAByte) {
  bus.add({.kind = BusEventKind::corrupt, .begin_ns = 10 * ms, .count = 1, .byte = 3, .mask = 0x81});
  put(2);
  CanFrame first;
  CanFrame second;
  ASSERT_EQ(bus.receive(first, {}), CanReceive::got);
  ASSERT_EQ(bus.receive(second, {}), CanReceive::got);
  EXPECT_EQ(first.data[3], 0x81);
  EXPECT_EQ(second.data[3], 0x00);
}

TEST_F(VirtualCanBusTest, DelaysDoublesAndReorders) {
  bus.add({.kind = BusEventKind::delay, .begin_ns = 10 * ms, .count = 1, .delay_ns = 15 * ms});
  bus.add({.kind = BusEventKind::duplicate, .begin_ns = 30 * ms, .count = 1, .delay_ns = 4 * ms});
  bus.add({.kind = BusEventKind::reorder, .begin_ns = 40 * ms, .end_ns = 99 * ms, .count = 1});
  put(5);
  EXPECT_THAT(arrivals(60 * ms),
              ElementsAre(Pair(2, 20), Pair(1, 25), Pair(3, 30), Pair(3, 34), Pair(5, 50), Pair(4, 50)));
}

TEST_F(VirtualCanBusTest, AFrameThatNothingOvertakesArrivesAtTheEndOfTheEvent) {
  bus.add({.kind = BusEventKind::reorder, .begin_ns = 10 * ms, .end_ns = 35 * ms, .count = 1});
  put(1);
  EXPECT_EQ(bus.next_arrival_ns(), never_ns);
  timeline.run_until(40 * ms);
  EXPECT_THAT(arrivals(60 * ms), ElementsAre(Pair(1, 35)));
}

TEST_F(VirtualCanBusTest, ABurstArrivesTogetherAtItsEnd) {
  bus.add({.kind = BusEventKind::burst, .begin_ns = 15 * ms, .end_ns = 45 * ms});
  put(5);
  EXPECT_THAT(arrivals(60 * ms),
              ElementsAre(Pair(1, 10), Pair(2, 45), Pair(3, 45), Pair(4, 45), Pair(5, 50)));
}

TEST_F(VirtualCanBusTest, InsertsAFrame) {
  bus.add({.kind = BusEventKind::insert, .begin_ns = 15 * ms, .frame = frame(9)});
  put(2);
  EXPECT_THAT(arrivals(30 * ms), ElementsAre(Pair(1, 10), Pair(9, 15), Pair(2, 20)));
}

TEST_F(VirtualCanBusTest, BusOffIsAnErrorFrameAndThenSilenceBothWays) {
  bus.add({.kind = BusEventKind::bus_off, .begin_ns = 15 * ms, .end_ns = 35 * ms});
  put(3);
  EXPECT_EQ(bus.send(frame(1)), CanSend::no_buffer);
  timeline.run_until(35 * ms);
  EXPECT_EQ(bus.send(frame(1)), CanSend::ok);
  bus.put(frame(4));
  EXPECT_THAT(arrivals(60 * ms), ElementsAre(Pair(-1, 15), Pair(4, 35)));
  EXPECT_EQ(bus.stats().bus_off, 1U);
  EXPECT_EQ(bus.stats().send_dropped, 1U);
}

TEST_F(VirtualCanBusTest, AnInterfaceThatIsDownLosesWhatWasOnTheWay) {
  bus.add({.kind = BusEventKind::delay, .begin_ns = 10 * ms, .count = 1, .delay_ns = 12 * ms});
  bus.add({.kind = BusEventKind::interface_down, .begin_ns = 15 * ms, .end_ns = 35 * ms});
  put(3);
  CanFrame none;
  EXPECT_EQ(bus.receive(none, {}), CanReceive::down);
  EXPECT_EQ(bus.send(frame(1)), CanSend::down);
  timeline.run_until(36 * ms);
  EXPECT_THAT(arrivals(60 * ms), IsEmpty());
  EXPECT_EQ(bus.counts().lost, 3U);
  EXPECT_EQ(bus.stats().reopened, 1U);
}

TEST_F(VirtualCanBusTest, AReceiverThatActsBeforeTheBusGoesOnWhileTheInterfaceIsDown) {
  VirtualClock time{};
  VirtualCanBus other{time};
  VirtualTimeline order{time};
  int calls = 0;
  order.add({.next_due_ns = [&] { return other.next_arrival_ns(); },
             .act =
                 [&] {
                   CanFrame x;
                   // Time stands still while this goes on for ever; a test has to end.
                   if (++calls > 10) throw std::runtime_error{"the receiver is called again and again"};
                   while (other.receive(x, {}) == CanReceive::got) {
                   }
                 }});
  order.add(other.party());
  other.add({.kind = BusEventKind::delay, .begin_ns = 0, .count = 1, .delay_ns = 15 * ms});
  other.add({.kind = BusEventKind::interface_down, .begin_ns = 15 * ms, .end_ns = 35 * ms});
  other.put(frame(1));
  ASSERT_NO_THROW(order.run_until(40 * ms));
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(other.counts().lost, 1U);
  EXPECT_EQ(other.next_arrival_ns(), never_ns);
  EXPECT_EQ(other.stats().reopened, 1U);
}

TEST_F(VirtualCanBusTest, AFrameThatIsReleasedAsTheInterfaceGoesDownIsLostAndCounted) {
  bus.add({.kind = BusEventKind::reorder, .begin_ns = 10 * ms, .end_ns = 15 * ms, .count = 1});
  bus.add({.kind = BusEventKind::interface_down, .begin_ns = 15 * ms, .end_ns = 35 * ms});
  put(1);
  EXPECT_THAT(arrivals(60 * ms), IsEmpty());
  EXPECT_EQ(bus.counts().lost, 1U);
}

TEST_F(VirtualCanBusTest, WhatTheDriveSendsIsHeardByOthersAndNotByItself) {
  std::vector<std::int64_t> heard;
  bus.listen([&](const CanFrame& x) { heard.push_back(x.received_ns); });
  timeline.run_until(7 * ms);
  EXPECT_EQ(bus.send(frame(1)), CanSend::ok);
  EXPECT_THAT(heard, ElementsAre(7 * ms));
  EXPECT_THAT(arrivals(10 * ms), IsEmpty());
}

TEST_F(VirtualCanBusTest, RefusesEventsThatMakeNoSense) {
  EXPECT_THROW(bus.add({.begin_ns = 5, .end_ns = 5}), std::invalid_argument);
  EXPECT_THROW(bus.add({.kind = BusEventKind::burst}), std::invalid_argument);
  EXPECT_THROW(bus.add({.kind = BusEventKind::delay, .delay_ns = -1}), std::invalid_argument);
  EXPECT_THROW(bus.add({.kind = BusEventKind::corrupt, .mask = 0}), std::invalid_argument);
  EXPECT_THROW(bus.add({.kind = BusEventKind::corrupt, .byte = 64}), std::invalid_argument);
}

}  // namespace
}  // namespace sextant
