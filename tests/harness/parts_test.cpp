// The small parts of the harness: clock, timeline, late wake-ups, digest, random events, vehicle.

#include <limits>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/harness/digest.hpp"
#include "sextant/harness/late_wakes.hpp"
#include "sextant/harness/random_bus_events.hpp"
#include "sextant/harness/virtual_timeline.hpp"
#include "sextant/harness/virtual_vehicle.hpp"

namespace sextant {
namespace {

using ::testing::ElementsAre;

TEST(VirtualClock, MovesForwardOnly) {
  VirtualClock clock{5};
  clock.advance_to(5);
  clock.advance_to(9);
  EXPECT_EQ(clock.now_ns(), 9);
  EXPECT_THROW(clock.advance_to(8), std::logic_error);
}

TEST(VirtualTimeline, PartiesActInOrderOfTimeAndThenOfAddition) {
  VirtualClock clock;
  VirtualTimeline timeline{clock};
  std::vector<std::pair<char, std::int64_t>> seen;
  struct Beat {
    std::int64_t next, every;
  };
  Beat a{3, 3};
  Beat b{2, 2};
  for (auto [name, beat] : {std::pair{'a', &a}, std::pair{'b', &b}}) {
    timeline.add({[beat] { return beat->next; },
                  [&, name, beat] {
                    seen.emplace_back(name, clock.now_ns());
                    beat->next += beat->every;
                  }});
  }
  timeline.run_until(6);
  EXPECT_THAT(seen, ElementsAre(std::pair{'b', 2}, std::pair{'a', 3}, std::pair{'b', 4}, std::pair{'a', 6},
                                std::pair{'b', 6}));
  timeline.run_until(7);
  EXPECT_EQ(clock.now_ns(), 7);
}

TEST(VirtualTimeline, WhatIsOverdueActsNow) {
  VirtualClock clock{100};
  VirtualTimeline timeline{clock};
  std::int64_t next = 10;
  timeline.add({[&] { return next; },
                [&] {
                  EXPECT_EQ(clock.now_ns(), 100);
                  next = never_ns;
                }});
  timeline.run_until(100);
  EXPECT_EQ(next, never_ns);
}

TEST(LateWakes, ActOnOneDeadlineEach) {
  LateWakes late{{{95, 7}, {200, 3}}};
  EXPECT_EQ(late.wake_ns(90), 90);
  late.woken(90);
  EXPECT_EQ(late.wake_ns(100), 107);
  late.woken(100);
  EXPECT_EQ(late.wake_ns(110), 110);
  EXPECT_EQ(late.wake_ns(200), 203);
  EXPECT_THROW((LateWakes{{{5, 1}, {4, 1}}}), std::invalid_argument);
  EXPECT_THROW((LateWakes{{{5, -1}}}), std::invalid_argument);
}

/// The digest of one period that `change` has changed.
template <class Change>
std::uint64_t digest_with(Change&& change) {
  Telemetry<double> t;
  change(t);
  Digest digest;
  digest.add(t);
  return digest.value();
}

TEST(Digest, SeesEveryMemberOfTheTelemetry) {
  using T = Telemetry<double>;
  FaultSet fault;
  fault.set(Fault::transmit_lost);
  const std::vector<std::uint64_t> digests{
      digest_with([](T&) {}),
      digest_with([](T& t) { t.t_ns = 1; }),
      digest_with([](T& t) { t.torque_requested = 1e-300; }),
      digest_with([](T& t) { t.torque_reference = 1e-300; }),
      digest_with([](T& t) { t.torque = -0.0; }),
      digest_with([](T& t) { t.psi_s.alpha = 1; }),
      digest_with([](T& t) { t.psi_s.beta = 1; }),
      digest_with([](T& t) { t.psi_s_magnitude = 1; }),
      digest_with([](T& t) { t.i_abc.a = 1; }),
      digest_with([](T& t) { t.i_abc.b = 1; }),
      digest_with([](T& t) { t.i_abc.c = 1; }),
      digest_with([](T& t) { t.u_dc = 1; }),
      digest_with([](T& t) { t.i_dc = 1; }),
      digest_with([](T& t) { t.omega_m = 1; }),
      digest_with([](T& t) { t.torque_motoring = 1; }),
      digest_with([](T& t) { t.torque_regenerating = 1; }),
      digest_with([](T& t) { t.pattern = {switch_states[0], 25'000}; }),
      digest_with([](T& t) { t.pattern = {switch_states[7], 25'000}; }),
      digest_with([](T& t) { t.sector = 1; }),
      digest_with([](T& t) { t.state = DriveState::shutdown; }),
      digest_with([](T& t) { t.lockout = false; }),
      digest_with([&](T& t) { t.active = fault; }),
      digest_with([&](T& t) { t.latched = fault; }),
      digest_with([](T& t) { t.first_fault = Fault::transmit_lost; }),
      digest_with([](T& t) { t.fault_total = 1; }),
      digest_with([](T& t) { t.command_received_ns = 1; }),
      digest_with([](T& t) { t.command_sequence = 1; }),
      digest_with([](T& t) { t.command_rejected = 1; }),
      digest_with([](T& t) { t.command_counter = 1; }),
  };
  std::vector<std::uint64_t> different = digests;
  std::ranges::sort(different);
  different.erase(std::ranges::unique(different).begin(), different.end());
  EXPECT_EQ(different.size(), digests.size());
}

TEST(Digest, SeesFramesTimesAndOrder) {
  const auto of = [](std::initializer_list<CanFrame> frames, std::int64_t t_ns) {
    Digest digest;
    for (const CanFrame& f : frames) digest.add(f, t_ns);
    return digest.value();
  };
  const CanFrame a{.id = 1, .length = 3, .data = {1, 2, 3}};
  const CanFrame b{.id = 1, .length = 3, .data = {1, 2, 4}};
  const CanFrame c{.id = 1, .length = 2, .data = {1, 2}};
  CanFrame d = a;
  d.rtr = true;
  std::vector<std::uint64_t> digests{of({a}, 0), of({b}, 0),    of({c}, 0),   of({d}, 0),
                                     of({a}, 1), of({a, b}, 0), of({b, a}, 0)};
  std::ranges::sort(digests);
  EXPECT_EQ(std::ranges::unique(digests).begin(), digests.end());
}

TEST(RandomBusEvents, AreTheSameForOneSeedAndKeepTheirLimits) {
  const RandomBusEvents wanted{.seed = 3, .begin_ns = 1000, .end_ns = 900'000'000};
  const std::vector<BusEvent> events = draw(wanted);
  const std::vector<BusEvent> again = draw(wanted);
  ASSERT_GT(events.size(), 5U);
  ASSERT_EQ(events.size(), again.size());
  for (std::size_t k = 0; k < events.size(); ++k) {
    EXPECT_EQ(events[k].validate(), nullptr) << events[k].validate();
    EXPECT_EQ(events[k].begin_ns, again[k].begin_ns);
    EXPECT_EQ(events[k].kind, again[k].kind);
    EXPECT_GE(events[k].begin_ns, wanted.begin_ns);
    EXPECT_LE(events[k].end_ns, wanted.end_ns);
    EXPECT_LE(events[k].count, wanted.most_frames);
  }
  RandomBusEvents other = wanted;
  other.seed = 4;
  EXPECT_NE(draw(other).front().begin_ns, events.front().begin_ns);
  EXPECT_THROW((void)draw({.begin_ns = 5, .end_ns = 5}), std::invalid_argument);
  EXPECT_THROW((void)draw({.kinds = {}}), std::invalid_argument);
}

/// The engine is the standard's: the 10000th number of the default seed is written there (26.6.5).
TEST(RandomBusEvents, TheirEngineIsTheSameEverywhere) {
  const std::vector<BusEvent> events = draw({.seed = 5489, .mean_gap_ns = 1'000'000});
  // 14514284786278117030 is its first number; the gap is the remainder by 2 mean + 1.
  EXPECT_EQ(events.front().begin_ns, std::int64_t(14514284786278117030ULL % 2'000'001ULL));
}

TEST(VirtualVehicle, RefusesWhatCannotBe) {
  VirtualClock clock;
  VirtualCanBus bus{clock};
  const auto make = [&](const VirtualVehicle::Parameters& p) {
    const VirtualVehicle vehicle{p, clock, bus, [](std::int64_t) { return 0.0; }};
  };
  EXPECT_NO_THROW(make({}));
  EXPECT_THROW(make({.period_ns = 0}), std::invalid_argument);
  EXPECT_THROW(make({.closing_frames = -1}), std::invalid_argument);
  EXPECT_THROW(make({.first_counter = 15}), std::invalid_argument);
}

}  // namespace
}  // namespace sextant
