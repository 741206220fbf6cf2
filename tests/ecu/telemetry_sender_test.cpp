#include "ecu/telemetry/telemetry_sender.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

/// The other end of the way, and what has come.
struct Taken {
  std::vector<std::uint64_t> intervals{};
  std::vector<std::int64_t> states{};  // t_ns
  int statistics{0};
};

Taken take_all(MessageSocket& socket) {
  Taken taken;
  std::array<std::byte, 4096> buffer{};
  while (const auto message = socket.receive(buffer)) {
    if (message->empty()) break;
    const auto kind = kind_of(*message);
    if (kind == TelemetryMessageKind::interval) {
      taken.intervals.push_back(content_of<IntervalMessage>(*message).value().sequence);
    }
    if (kind == TelemetryMessageKind::state) {
      taken.states.push_back(content_of<StateMessage>(*message).value().sample().t_ns);
    }
    if (kind == TelemetryMessageKind::statistics) ++taken.statistics;
  }
  return taken;
}

TEST(TelemetrySender, ReadersSeeAGapWhereNobodyTookASample) {
  TelemetrySender sender;
  sender.write(TelemetryIntervalRecord<double>{}, 0);
  sender.write(TelemetryIntervalRecord<double>{}, 0);
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  sender.write(TelemetryIntervalRecord<double>{}, 0);
  EXPECT_EQ(take_all(other).intervals, (std::vector<std::uint64_t>{2}));
  EXPECT_EQ(sender.dropped(), 2U);
}

TEST(TelemetrySender, TheNewestStateWaitsForRoom) {
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  while (sender.dropped() == 0) sender.write(TelemetryIntervalRecord<double>{}, 0);
  sender.write(DriveStateSample{.t_ns = 1});
  sender.write(DriveStateSample{.t_ns = 2});
  sender.write(RealTimeSample{});
  const Taken before = take_all(other);
  EXPECT_TRUE(before.states.empty());
  EXPECT_EQ(before.statistics, 0);
  sender.send_kept();
  const Taken after = take_all(other);
  EXPECT_EQ(after.states, (std::vector<std::int64_t>{2}));
  EXPECT_EQ(after.statistics, 1);
  EXPECT_EQ(sender.dropped(), 2U) << "one interval, one state";
  sender.send_kept();
  EXPECT_TRUE(take_all(other).states.empty()) << "once is enough";
}

TEST(TelemetrySender, AProcessThatIsNewLearnsHowThingsStand) {
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  sender.write(DriveStateSample{.t_ns = 1});
  sender.disconnect();
  EXPECT_FALSE(sender.connected());
  sender.write(RealTimeSample{});
  auto [own_again, new_other] = MessageSocket::pair();
  sender.connect(std::move(own_again));
  sender.send_kept();
  const Taken taken = take_all(new_other);
  EXPECT_EQ(taken.states, (std::vector<std::int64_t>{1}));
  EXPECT_EQ(taken.statistics, 1);
}

TEST(TelemetrySender, WhatAProcessHadNotReceivedBeforeItsEndIsCounted) {
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  sender.write(TelemetryIntervalRecord<double>{.periods = 40}, 0);
  sender.write(TelemetryIntervalRecord<double>{.periods = 7}, 0);
  sender.write(DriveStateSample{.t_ns = 1});
  sender.write(DriveStateSample{.t_ns = 2});
  sender.write(RealTimeSample{});
  EXPECT_EQ(sender.dropped(), 0U) << "all are on their way";
  std::array<std::byte, 4096> buffer{};
  while (const auto message = other.receive(buffer)) sender.count_lost(*message);
  sender.disconnect();
  EXPECT_EQ(sender.dropped(), 3U) << "two intervals and the state before the newest";
  EXPECT_EQ(sender.dropped_periods(), 47U);
  sender.write(DriveStateSample{.t_ns = 3});
  EXPECT_EQ(sender.dropped(), 4U) << "the second state was never received either";
}

TEST(TelemetrySender, CountsControlPeriodsOfIntervalsWithoutRoom) {
  TelemetrySender sender;
  sender.write(TelemetryIntervalRecord<double>{.periods = 40}, 0);
  sender.write(WaveformBatch{}, 0);
  EXPECT_EQ(sender.dropped(), 2U);
  EXPECT_EQ(sender.dropped_periods(), 40U) << "a batch repeats periods of intervals";
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  sender.write(TelemetryIntervalRecord<double>{.periods = 40}, 0);
  EXPECT_EQ(sender.dropped_periods(), 40U);
  while (sender.dropped() == 2) sender.write(TelemetryIntervalRecord<double>{.periods = 5}, 0);
  EXPECT_EQ(sender.dropped_periods(), 45U);
  EXPECT_FALSE(take_all(other).intervals.empty());
}

TEST(TelemetrySender, AProcessThatIsGoneIsNoError) {
  TelemetrySender sender;
  {
    auto [own, other] = MessageSocket::pair();
    sender.connect(std::move(own));
  }
  sender.write(TelemetryIntervalRecord<double>{}, 0);
  sender.write(DriveStateSample{});
  sender.send_kept();
  EXPECT_EQ(sender.dropped(), 1U);
}

}  // namespace
}  // namespace sextant::ecu
