// The small parts of virtual time: clock, timeline, late wake-ups, digest, random events, vehicle.

#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/virtual_time/digest.hpp"
#include "sextant/virtual_time/late_wakes.hpp"
#include "sextant/virtual_time/random_bus_events.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"
#include "sextant/virtual_time/virtual_vehicle.hpp"

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

std::uint64_t digest_of(const Telemetry<double>& t) {
  Digest digest;
  digest.add(t);
  return digest.value();
}

// Adds to `values` one for each way in which a member differs from what it is.
void add_changes(std::vector<double>& values, double) {
  values.assign({-0.0, 1e-300});
}
void add_changes(std::vector<std::optional<double>>& values, std::optional<double>) {
  values.assign({0.0, 1e-300});
}
void add_changes(std::vector<bool>& values, bool x) {
  values.push_back(!x);
}
template <class Integer>
  requires std::is_integral_v<Integer>
void add_changes(std::vector<Integer>& values, Integer x) {
  for (Integer bit = 1; bit > 0; bit = Integer(bit << 1)) values.push_back(Integer(x ^ bit));
}
template <class Enumeration>
  requires std::is_enum_v<Enumeration>
void add_changes(std::vector<Enumeration>& values, Enumeration x) {
  for (std::uint8_t n = 0; n < 16; ++n) {
    if (Enumeration{n} != x) values.push_back(Enumeration{n});
  }
}
void add_changes(std::vector<ThreePhase<double>>& values, ThreePhase<double>) {
  values.assign({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
}
void add_changes(std::vector<SpaceVector<double>>& values, SpaceVector<double>) {
  values.assign({{1, 0}, {0, 1}});
}
void add_changes(std::vector<FaultSet>& values, FaultSet) {
  for (std::uint8_t n = 0; n < 64; ++n) {
    values.emplace_back();
    values.back().set(Fault{n});
  }
}
void add_changes(std::vector<GatePattern>& values, const GatePattern&) {
  GatePattern two{switch_states[1], 10'000};
  (void)two.append({switch_states[2], 15'000});
  GatePattern other_first{switch_states[3], 10'000};
  (void)other_first.append({switch_states[2], 15'000});
  GatePattern other_times{switch_states[1], 15'000};
  (void)other_times.append({switch_states[2], 10'000});
  values.assign({{switch_states[0], 25'000},
                 {switch_states[2], 25'000},
                 {switch_states[2], 15'000},
                 two,
                 other_first,
                 other_times});
}

/// The digests of a period of zeros in which each member in turn has each of its changes.
std::vector<std::uint64_t> digests_of_changes() {
  Telemetry<double> t;
  std::vector<std::uint64_t> digests{digest_of(t)};
  const auto change = [&](auto& member) {
    const auto before = member;
    std::vector<std::remove_cvref_t<decltype(member)>> values;
    add_changes(values, before);
    for (const auto& value : values) {
      member = value;
      digests.push_back(digest_of(t));
    }
    member = before;
  };
  auto& [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, c0, c1, c2, c3, c4,
         c5, c6, c7, c8, c9, d0, d1, d2, d3, d4] = t;
  const auto all = std::tie(a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, b0, b1, b2, b3, b4, b5, b6, b7, b8, b9,
                            c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, d0, d1, d2, d3, d4);
  std::apply([&](auto&... members) { (change(members), ...); }, all);
  return digests;
}

TEST(Digest, SeesEveryMemberOfTheTelemetry) {
  std::vector<std::uint64_t> digests = digests_of_changes();
  const std::size_t count = digests.size();
  std::ranges::sort(digests);
  digests.erase(std::ranges::unique(digests).begin(), digests.end());
  EXPECT_EQ(digests.size(), count);
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
