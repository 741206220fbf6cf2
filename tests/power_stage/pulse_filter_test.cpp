// The minimum pulse of the simulated inverter against a restatement nanosecond by nanosecond, and against the
// volt-seconds of a pulse of the length w: dropped it lacks u_dc w, stretched it has u_dc (t_min − w) more,
// in the direction of the pulse.
#include "sextant/power_stage/pulse_filter.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

constexpr auto low = LegState::low;
constexpr auto high = LegState::high;
constexpr auto off = LegState::off;
using Nanoseconds = std::vector<LegState>;  // of a leg, one for each

/// The state that was commanded for the last n nanoseconds before the end of the last such stretch; off where
/// the leg has been off since.
Nanoseconds dropped(const Nanoseconds& commanded, std::int32_t n) {
  Nanoseconds acting;
  for (std::size_t t = 0; t < commanded.size(); ++t) {
    LegState found = off;
    for (std::size_t end = t; commanded[t] != off && end >= std::size_t(n); --end) {
      if (commanded[end - 1] == off) break;
      std::int32_t same = 1;
      while (same < n && commanded[end - 1 - std::size_t(same)] == commanded[end - 1]) ++same;
      if (same < n) continue;
      found = commanded[end - 1];
      break;
    }
    acting.push_back(found);
  }
  return acting;
}

/// The commanded state, unless the last change is less than n nanoseconds old.
Nanoseconds stretched(const Nanoseconds& commanded, std::int32_t n) {
  Nanoseconds acting;
  std::int64_t changed = -n;
  for (std::int64_t t = 0; t < std::int64_t(commanded.size()); ++t) {
    const LegState now = commanded[std::size_t(t)];
    const LegState before = acting.empty() ? off : acting.back();
    const bool holds = now != off && before != off && t - changed < n;
    acting.push_back(holds ? before : now);
    if (acting.back() != before) changed = t;
  }
  return acting;
}

std::int64_t short_ones(const Nanoseconds& commanded, std::int32_t n) {
  std::int64_t count = 0;
  for (std::size_t begin = 0, t = 1; t < commanded.size(); ++t) {
    if (commanded[t] == commanded[begin]) continue;
    const bool is_pulse = commanded[begin] != off && commanded[t] != off;
    count += is_pulse && t - begin < std::size_t(n) ? 1 : 0;
    begin = t;
  }
  return count;
}

void add(std::array<Nanoseconds, 3>& legs, std::span<const GateSegment> segments) {
  for (const auto& [state, ns] : segments) {
    const std::array<LegState, 3> states{state.a(), state.b(), state.c()};
    for (std::size_t x = 0; x < 3; ++x) legs[x].insert(legs[x].end(), std::size_t(ns), states[x]);
  }
}

/// Patterns of up to eight segments, now and then with legs off.
GatePattern random_pattern(std::mt19937& random, int longest_ns) {
  const auto draw = [&random](int lowest, int highest) {
    return std::uniform_int_distribution{lowest, highest}(random);
  };
  const auto leg = [&] {
    const int k = draw(0, 30);
    return k == 0 ? off : k % 2 == 0 ? low : high;
  };
  GatePattern pattern;
  const int segments = draw(1, int(GatePattern::capacity));
  for (int n = 0; n < segments; ++n) pattern.append({{leg(), leg(), leg()}, draw(1, longest_ns)});
  return pattern;
}

class PulseFilterOf : public testing::TestWithParam<ShortPulses> {};

TEST_P(PulseFilterOf, PassesWhatARestatementNanosecondByNanosecondPasses) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  for (const std::int32_t shortest_ns : {1, 2, 20}) {
    PulseFilter filter{{shortest_ns, GetParam()}};
    std::array<Nanoseconds, 3> commanded;
    std::array<Nanoseconds, 3> passed;
    for (int k = 0; k < 1'000; ++k) {
      const GatePattern pattern = random_pattern(random, k % 3 == 0 ? 10 : 50);
      add(commanded, pattern.segments());
      add(passed, filter.step(pattern.segments()).segments());
    }
    std::int64_t shorter = 0;
    for (std::size_t x = 0; x < 3; ++x) {
      SCOPED_TRACE(testing::Message() << shortest_ns << " ns, leg " << x);
      const bool drops = GetParam() == ShortPulses::dropped;
      const Nanoseconds due =
          drops ? dropped(commanded[x], shortest_ns) : stretched(commanded[x], shortest_ns);
      ASSERT_EQ(passed[x].size(), due.size());
      EXPECT_EQ(std::ranges::mismatch(passed[x], due).in2 - due.begin(), std::ptrdiff_t(due.size()));
      shorter += short_ones(commanded[x], shortest_ns);
    }
    EXPECT_EQ(filter.short_pulses(), shorter);
    EXPECT_EQ(shorter > 0, shortest_ns > 1);
  }
}

// As much as a pattern can be taken apart, in front of dead times.
TEST_P(PulseFilterOf, ThereIsRoomForEverySegment) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  PulseFilter filter{{30, GetParam()}};
  DeadTime dead_time{7};
  for (int k = 0; k < 50'000; ++k) {
    const GatePattern pattern = random_pattern(random, 60);
    const ActedSegments passed = filter.step(pattern.segments());
    ASSERT_LE(passed.segments().size(), 3 * GatePattern::capacity + 3 + 1);
    const ActedSegments acted = dead_time.step(passed.segments());
    ASSERT_LE(acted.segments().size(), ActedSegments::capacity);
    std::int64_t duration_ns = 0;
    for (const GateSegment& segment : acted.segments()) duration_ns += segment.duration_ns;
    ASSERT_EQ(duration_ns, pattern.duration_ns());
  }
}

constexpr std::int32_t period_ns = 25'000;
constexpr std::int32_t shortest_ns = 2'000;
constexpr double u_dc = 530.0;

SimulatedPowerStage::Parameters stage_of(IntegratorKind integrator, const MinimumPulse::Parameters& minimum) {
  SimulatedPowerStage::Parameters p;
  p.integrator = integrator;
  p.io.u_dc = u_dc;
  p.io.minimum_pulse = minimum;
  p.cvode.relative_tolerance = p.erk.relative_tolerance = 1e-9;
  return p;
}

/// One leg is commanded otherwise than the others for some time, from so long before the end of a period on.
struct Pulse {
  SwitchState rest;
  SwitchState pulse;
  std::int32_t duration_ns;
  std::int32_t before_end_ns;
};

/// Of the stator flux over three periods at standstill. [Wb]
SpaceVector<> flux_change(IntegratorKind integrator, const MinimumPulse::Parameters& minimum,
                          const Pulse& p) {
  using Stage = SimulatedPowerStage;
  const MechanicalLoad standstill{{.imposed_speed = ProfileParameters{.value = 0.0}}};
  const Stage::Parameters parameters = stage_of(integrator, minimum);
  Stage::Plant plant{parameters.plant};
  const auto moves = Stage::make_integrator(parameters);
  Stage::Io io{parameters.io, plant, *moves, standstill};
  static_cast<void>(io.read(0));
  GatePattern first{p.rest, period_ns - p.before_end_ns};
  const std::int32_t here_ns = std::min(p.duration_ns, p.before_end_ns);
  first.append({p.pulse, here_ns});
  first.append({p.rest, p.before_end_ns - here_ns});
  GatePattern second;
  second.append({p.pulse, p.duration_ns - here_ns});
  second.append({p.rest, period_ns - (p.duration_ns - here_ns)});
  const GatePattern rest{p.rest, period_ns};
  std::int64_t t_ns = 0;
  for (const GatePattern& pattern : {rest, first, second, rest}) {
    io.write(pattern);
    const Measurement<> measured = io.read(t_ns += period_ns);
    EXPECT_TRUE(measured.plausible);
    EXPECT_EQ(measured.applied.duration_ns(), period_ns) << "the edges that were commanded";
  }
  return plant.psi_s();
}

TEST(PulseFilter, AShortPulseLacksOrHasMoreVoltSecondsAcrossTheEndOfAPeriodAsWell) {
  constexpr std::array<IntegratorKind, 4> integrators{IntegratorKind::fixed, IntegratorKind::exact,
                                                      IntegratorKind::cvode, IntegratorKind::erk};
  const SwitchState v0 = switch_states[0];
  const SwitchState v7 = switch_states[7];
  for (const IntegratorKind integrator : integrators) {
    for (const std::int32_t before_end_ns : {10'000, 400, 0}) {
      SCOPED_TRACE(testing::Message() << "integrator " << int(integrator) << ", " << before_end_ns << " ns");
      for (const std::int32_t ns : {900, shortest_ns, 3'000}) {
        const double w = ns * 1e-9;
        const double more = ns < shortest_ns ? (shortest_ns - ns) * 1e-9 : 0.0;
        const double less = ns < shortest_ns ? w : 0.0;
        const Pulse up{v0, switch_states[1], ns, before_end_ns};
        const Pulse down{v7, switch_states[4], ns, before_end_ns};
        const auto alpha = [&](ShortPulses kind, const Pulse& p) {
          return flux_change(integrator, {shortest_ns, kind}, p).alpha;
        };
        const double near = 0.01 * 2.0 / 3.0 * u_dc * 3e-6;  // resistances take 1 % in two periods
        const auto flux = [](double seconds) { return 2.0 / 3.0 * u_dc * seconds; };
        EXPECT_NEAR(flux_change(integrator, {}, up).alpha, flux(w), near);
        EXPECT_NEAR(alpha(ShortPulses::dropped, up), flux(w - less), near);
        EXPECT_NEAR(alpha(ShortPulses::stretched, up), flux(w + more), near);
        EXPECT_NEAR(alpha(ShortPulses::dropped, down), -flux(w - less), near);
        EXPECT_NEAR(alpha(ShortPulses::stretched, down), -flux(w + more), near);
      }
    }
  }
}

TEST_P(PulseFilterOf, GatesTurnOffAtOnce) {
  PulseFilter filter{{shortest_ns, GetParam()}};
  static_cast<void>(filter.step(GatePattern{switch_states[0], period_ns}.segments()));
  GatePattern trip{switch_states[1], 500};
  trip.append({gates_off, period_ns - 500});
  const ActedSegments passed = filter.step(trip.segments());
  const SwitchState before = switch_states[GetParam() == ShortPulses::dropped ? 0 : 1];
  ASSERT_EQ(passed.segments().size(), 2U);
  EXPECT_EQ(passed.segments()[0], (GateSegment{before, 500}));
  EXPECT_EQ(passed.segments()[1], (GateSegment{gates_off, period_ns - 500}));
}

INSTANTIATE_TEST_SUITE_P(PulseFilter, PulseFilterOf,
                         testing::Values(ShortPulses::dropped, ShortPulses::stretched));

TEST(PulseFilter, FromTheDeadTimeToBelowHalfOfThePeriod) {
  SimulatedDriveIoParameters p;
  p.period_ns = period_ns;
  p.dead_time_ns = 1'500;
  for (const std::int32_t right_ns : {0, 1'500, period_ns / 2 - 1}) {
    p.minimum_pulse.duration_ns = right_ns;
    EXPECT_EQ(p.validate(), nullptr) << right_ns;
  }
  for (const std::int32_t wrong_ns : {-1, period_ns / 2, 2'000'000'000}) {
    p.minimum_pulse.duration_ns = wrong_ns;
    EXPECT_STREQ(p.validate(), "the minimum pulse must be from zero to below half of the control period");
  }
  p.minimum_pulse.duration_ns = 1'499;
  EXPECT_STREQ(
      p.validate(),
      "the minimum pulse must be zero or at least the dead time: a shorter pulse turns no switch on");
}

}  // namespace
}  // namespace sextant
