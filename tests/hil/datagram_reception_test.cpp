#include "sextant/hil/datagram_reception.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 250'000;
constexpr std::int64_t quiet_ns = 5'000'000;
constexpr std::size_t size = sizeof(CommandDatagram);

class DatagramReceptionTest : public testing::Test {
 protected:
  /// The datagram with that number, which was under way for 1 ms and so much more [ns].
  bool arrives(std::uint64_t sequence, std::int64_t delay_ns = 0) {
    DatagramHeader h;
    h.kind = std::uint16_t(DatagramKind::pattern);
    h.sequence = sequence;
    h.period_ns = period_ns;
    h.count = 1;
    h.generation = generation;
    h.sent_ns = std::int64_t(sequence) * period_ns;
    now_ns = h.sent_ns + 1'000'000 + delay_ns;
    return reception.accept(change(h), size, size, now_ns);
  }
  [[nodiscard]] const DatagramReception::Counters& counters() const { return reception.counters(); }

  /// The same of another start, so long after the newest [ns].
  bool arrives_from(std::uint32_t start, std::uint64_t sequence, std::int64_t after_ns) {
    DatagramHeader h;
    h.kind = std::uint16_t(DatagramKind::pattern);
    h.sequence = sequence;
    h.period_ns = period_ns;
    h.count = 1;
    h.generation = start;
    now_ns += after_ns;
    return reception.accept(h, size, size, now_ns);
  }

  DatagramReception reception{DatagramKind::pattern, period_ns, quiet_ns};
  DatagramHeader (*change)(DatagramHeader) = [](DatagramHeader h) { return h; };
  std::uint32_t generation{100};
  std::int64_t now_ns{0};
};

TEST_F(DatagramReceptionTest, WhatComesInOrderIsCountedAndNothingElse) {
  for (std::uint64_t n = 5; n < 200; ++n) EXPECT_TRUE(arrives(n));
  EXPECT_EQ(counters().received, 195U);
  EXPECT_EQ(counters().lost + counters().reordered + counters().repeated + counters().late, 0U)
      << "what was sent before we came is not lost";
}

TEST_F(DatagramReceptionTest, WhatNeverComesIsLostAndWhatComesLaterIsNot) {
  (void)arrives(1);
  (void)arrives(5);
  EXPECT_EQ(counters().lost, 3U);
  EXPECT_TRUE(arrives(3));
  EXPECT_EQ(counters().lost, 2U);
  EXPECT_EQ(counters().reordered, 1U);
  EXPECT_TRUE(arrives(3));
  EXPECT_EQ(counters().repeated, 1U);
  EXPECT_EQ(counters().reordered, 1U);
  (void)arrives(200);
  EXPECT_EQ(counters().lost, 2U + 194U);
}

// One such number would make all that the peer sends afterwards old, until both sides start again.
TEST_F(DatagramReceptionTest, ANumberThatThePeerCannotHaveReachedIsRefusedAndBlocksNothing) {
  for (std::uint64_t n = 1; n <= 10; ++n) EXPECT_TRUE(arrives(n));
  for (const std::uint64_t forged : {std::uint64_t{76}, std::uint64_t{1} << 32U, std::uint64_t{1} << 63U,
                                     std::numeric_limits<std::uint64_t>::max()}) {
    EXPECT_FALSE(arrives_from(generation, forged, 0)) << forged;
  }
  EXPECT_EQ(counters().foreign, 4U);
  for (std::uint64_t n = 11; n <= 20; ++n) EXPECT_TRUE(arrives(n));
  EXPECT_EQ(counters().lost + counters().reordered + counters().repeated, 0U);
}

// The queue of a receiver that stands still keeps the oldest datagrams: it reads them, and then the newest.
TEST_F(DatagramReceptionTest, FourNumbersInARowOutOfReachAreOfAReceiverThatStoodStill) {
  EXPECT_TRUE(arrives(1));
  for (std::uint64_t n = 3000; n < 3003; ++n) EXPECT_FALSE(arrives_from(generation, n, 0)) << n;
  EXPECT_FALSE(arrives_from(generation, 4000, 0)) << "no follower";
  for (std::uint64_t n = 3003; n < 3006; ++n) EXPECT_FALSE(arrives_from(generation, n, 0)) << n;
  EXPECT_TRUE(arrives_from(generation, 3006, 0));
  EXPECT_TRUE(arrives_from(generation, 3007, 0));
  EXPECT_EQ(counters().lost, 3006U - 2);
}

TEST_F(DatagramReceptionTest, AfterAPauseThePeerIsAsFarAsItCanBe) {
  EXPECT_TRUE(arrives(1));
  EXPECT_TRUE(arrives(100'001)) << "of a peer that went on for 25 s unheard";
  EXPECT_FALSE(arrives_from(generation, 100'001 + 64 + 2 * 40 + 1, 40 * period_ns));
  EXPECT_TRUE(arrives_from(generation, 100'001 + 64 + 2 * 80, 40 * period_ns));
}

TEST(LinkDatagram, HasTheRecordsOfItsHeader) {
  MeasurementDatagram m;
  m.header = {.sequence = 90, .generation = 7, .count = 3};
  for (std::uint32_t n = 0; n < 3; ++n) {
    m.records[n].sequence = 90 - n;
    m.records[n].generation = 7;
  }
  EXPECT_TRUE(is_of_its_header(m));
  for (std::uint32_t n = 0; n < 3; ++n) {
    MeasurementDatagram forged = m;
    forged.records[n].sequence = std::numeric_limits<std::uint64_t>::max();
    EXPECT_FALSE(is_of_its_header(forged)) << n;
    forged = m;
    forged.records[n].generation = 8;
    EXPECT_FALSE(is_of_its_header(forged)) << n;
  }
  CommandDatagram c;
  c.header = {.sequence = 5, .generation = 7, .count = 1};
  c.command.sequence = 5;
  c.command.generation = 7;
  EXPECT_TRUE(is_of_its_header(c));
  c.command.sequence = std::numeric_limits<std::uint64_t>::max();
  EXPECT_FALSE(is_of_its_header(c));
  c.command = {.sequence = 5, .generation = 8};
  EXPECT_FALSE(is_of_its_header(c));
}

TEST_F(DatagramReceptionTest, MoreThanTwoPeriodsBeyondTheFastestIsLate) {
  (void)arrives(1, 200'000);
  (void)arrives(2);
  (void)arrives(3, 2 * period_ns);
  EXPECT_EQ(counters().late, 0U);
  (void)arrives(4, 2 * period_ns + 1000);
  EXPECT_EQ(counters().late, 1U);
}

TEST_F(DatagramReceptionTest, ClocksThatPartSlowlyAreNotLateness) {
  for (std::uint64_t n = 1; n < 400'000; ++n)
    (void)arrives(n, std::int64_t(n) * period_ns / 20'000);  // 50 ppm
  EXPECT_EQ(counters().late, 0U);
}

TEST_F(DatagramReceptionTest, ANewStartBeginsAnewAndAStragglerOfTheOldOneIsNotTaken) {
  for (std::uint64_t n = 1; n < 50; ++n) (void)arrives(n);
  EXPECT_TRUE(arrives_from(7, 1, quiet_ns + 1)) << "at random: a later start may have a smaller number";
  EXPECT_EQ(counters().restarts, 1U);
  EXPECT_EQ(counters().lost, 0U);
  EXPECT_FALSE(arrives_from(100, 50, period_ns));
  EXPECT_EQ(counters().foreign, 1U);
}

TEST_F(DatagramReceptionTest, WhileTheAdoptedStartLivesNoOtherTakesItsPlace) {
  for (std::uint64_t n = 1; n < 50; ++n) {
    ASSERT_TRUE(arrives_from(100, n, period_ns));
    ASSERT_FALSE(arrives_from(7, n, 0));
    ASSERT_FALSE(arrives_from(8, n, 0));
  }
  EXPECT_EQ(counters().restarts, 0U);
  EXPECT_FALSE(arrives_from(7, 50, quiet_ns)) << "not yet quiet for longer than the limit";
  EXPECT_TRUE(arrives_from(7, 51, 1));
}

// Three starts, and what the network still held of each: the living one is always heard again.
TEST_F(DatagramReceptionTest, AStragglerOfAnyEarlierStartDoesNotLockTheLivingOneOut) {
  ASSERT_TRUE(arrives_from(1, 10, 0));
  ASSERT_TRUE(arrives_from(2, 1, 2 * quiet_ns));
  ASSERT_TRUE(arrives_from(3, 1, 2 * quiet_ns));
  EXPECT_FALSE(arrives_from(1, 11, 1));
  EXPECT_FALSE(arrives_from(2, 2, 1));
  for (std::uint64_t n = 2; n < 100; ++n) ASSERT_TRUE(arrives_from(3, n, period_ns)) << n;
  // It is quiet for a while, and just then a straggler comes: taken for a new start, and given up for it.
  ASSERT_TRUE(arrives_from(1, 12, 2 * quiet_ns));
  std::int64_t refused_ns = 0;
  std::uint64_t n = 100;
  while (!arrives_from(3, n++, period_ns)) {
    refused_ns += period_ns;
    ASSERT_LE(refused_ns, quiet_ns);
  }
  for (; n < 300; ++n) ASSERT_TRUE(arrives_from(3, n, period_ns)) << n;
  EXPECT_EQ(counters().restarts, 4U);
}

TEST_F(DatagramReceptionTest, ACountThatTheDatagramCannotHoldIsForeign) {
  change = [](DatagramHeader h) { return h.count = 0, h; };
  EXPECT_FALSE(arrives(1));
  change = [](DatagramHeader h) { return h.count = 2, h; };
  EXPECT_FALSE(arrives(2));
  EXPECT_EQ(counters().foreign, 2U);
  DatagramReception measurements{DatagramKind::measurement, period_ns, quiet_ns};
  DatagramHeader h;
  h.kind = std::uint16_t(DatagramKind::measurement);
  h.period_ns = period_ns;
  h.generation = 1;
  h.count = MeasurementDatagram::capacity;
  EXPECT_TRUE(measurements.accept(h, size, size, 0));
  ++h.count;
  EXPECT_FALSE(measurements.accept(h, size, size, 0));
}

TEST_F(DatagramReceptionTest, ClocksAtBothEndsOfTheirRangeAreNoError) {
  for (const std::int64_t sent_ns : {std::numeric_limits<std::int64_t>::min(), std::int64_t{0},
                                     std::numeric_limits<std::int64_t>::max()}) {
    for (const std::int64_t received_ns : {std::int64_t{0}, std::numeric_limits<std::int64_t>::max() / 2}) {
      DatagramReception fresh{DatagramKind::pattern, period_ns, quiet_ns};
      DatagramHeader h;
      h.kind = std::uint16_t(DatagramKind::pattern);
      h.sequence = 1;
      h.period_ns = period_ns;
      h.generation = 1;
      h.count = 1;
      h.sent_ns = sent_ns;
      EXPECT_TRUE(fresh.accept(h, size, size, received_ns));
      EXPECT_EQ(fresh.counters().late, 0U);
    }
  }
}

TEST_F(DatagramReceptionTest, WhatIsNotForUsIsRefusedAndCountedByItsReason) {
  change = [](DatagramHeader h) { return h.magic ^= 1U, h; };
  EXPECT_FALSE(arrives(1));
  change = [](DatagramHeader h) { return h.kind = 1, h; };
  EXPECT_FALSE(arrives(2));
  change = [](DatagramHeader h) { return ++h.version, h; };
  EXPECT_FALSE(arrives(3));
  change = [](DatagramHeader h) { return h.period_ns += 1, h; };
  EXPECT_FALSE(arrives(4));
  EXPECT_EQ(counters().foreign, 2U);
  EXPECT_EQ(counters().other_version, 1U);
  EXPECT_EQ(counters().other_period, 1U);
  DatagramHeader h;
  h.kind = std::uint16_t(DatagramKind::pattern);
  h.period_ns = period_ns;
  EXPECT_FALSE(reception.accept(h, size - 1, size, 0)) << "cut off";
  EXPECT_FALSE(reception.accept(h, 3, size, 0));
  EXPECT_EQ(counters().received, 0U);
}

}  // namespace
}  // namespace sextant
