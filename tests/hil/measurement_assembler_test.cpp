#include "sextant/hil/measurement_assembler.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 100'000;
constexpr std::int64_t measurement_timeout_ns = 1'000'000;
constexpr int missing_periods = 4;
constexpr int unacknowledged_periods = 10;

GatePattern state(int vector, std::int32_t duration_ns = period_ns) {
  return {switch_states[std::size_t(vector)], duration_ns};
}

class MeasurementAssemblerTest : public testing::Test {
 protected:
  MeasurementRecord record(const GatePattern& applied) {
    Measurement<double> m{.i_abc = {1, 2, -3}, .u_dc = 530, .applied = applied};
    m.omega_m = double(sequence);
    MeasurementRecord r = to_record(plant_ns += applied.duration_ns(), m);
    r.generation = generation;
    r.sequence = ++sequence;
    r.pattern_number = taken;
    return r;
  }

  /// One period of a drive that writes this; `applied` is what the plant made of the pattern it took last.
  Measurement<double> period(const GatePattern& written, const GatePattern& applied) {
    assembler.add(record(applied));
    const Measurement<double> m = assembler.take(plant_ns);
    assembler.wrote(++number, written.is_driven());
    return m;
  }

  MeasurementAssembler assembler{{.measurement_timeout_ns = measurement_timeout_ns,
                                  .missing_periods = missing_periods,
                                  .unacknowledged_periods = unacknowledged_periods}};
  std::uint64_t sequence{0};
  std::uint32_t generation{1};
  std::int64_t plant_ns{0};
  std::uint64_t number{1000};  // of the drive's command; that of an earlier drive at first
  std::uint64_t taken{0};      // of the command that the plant took last
};

TEST_F(MeasurementAssemblerTest, JoinsTheAppliedPatternsAndTakesTheNewestValues) {
  assembler.add(record(state(1)));
  (void)assembler.take(0);
  assembler.add(record(state(1)));
  assembler.add(record(state(1)));
  assembler.add(record(state(2)));
  const Measurement<double> m = assembler.take(1000);
  EXPECT_TRUE(m.plausible);
  EXPECT_EQ(m.omega_m, 3.0);
  EXPECT_EQ(m.i_abc.c, -3.0);
  GatePattern expected{switch_states[1], 2 * period_ns};
  expected.append({switch_states[2], period_ns});
  EXPECT_EQ(m.applied, expected);
  EXPECT_TRUE(m.applied.is_driven());
}

TEST_F(MeasurementAssemblerTest, RandomPatternsKeepTheirOrderAndDuration) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  for (int round = 0; round < 2000; ++round) {
    std::vector<SwitchState> nanoseconds;  // the state of each
    for (auto n = random() % 4; n > 0; --n) {
      GatePattern applied;
      for (auto k = random() % 3 + 1; k > 0; --k) {
        const auto duration = std::int32_t(random() % 5 + 1);
        const SwitchState s = random() % 9 == 0 ? gates_off : switch_states[random() % 2];
        applied.append({s, duration});
        nanoseconds.insert(nanoseconds.end(), std::size_t(duration), s);
      }
      assembler.add(record(applied));
    }
    const Measurement<double> m = assembler.take(0);
    if (!m.plausible || nanoseconds.empty()) continue;
    std::vector<SwitchState> joined;
    for (const GateSegment& s : m.applied.segments()) {
      joined.insert(joined.end(), std::size_t(s.duration_ns), s.state);
    }
    const auto changes =
        std::size_t(std::inner_product(nanoseconds.begin() + 1, nanoseconds.end(), nanoseconds.begin(), 0,
                                       std::plus<>{}, std::not_equal_to<>{}));
    if (changes >= GatePattern::capacity) {  // not the order, but the time of each state
      const auto by_code = [](SwitchState x, SwitchState y) { return x.code() < y.code(); };
      std::sort(nanoseconds.begin(), nanoseconds.end(), by_code);
      std::sort(joined.begin(), joined.end(), by_code);
    }
    ASSERT_EQ(joined, nanoseconds) << "round " << round;
  }
}

// As two periods of space-vector modulation.
TEST_F(MeasurementAssemblerTest, MoreChangesThanAPatternHoldsKeepTheTimeOfEachStateAndTheLastOne) {
  for (int n = 0; n < 25; ++n) assembler.add(record(state(n % 3)));
  const Measurement<double> m = assembler.take(0);
  EXPECT_TRUE(m.plausible);
  EXPECT_EQ(m.applied.duration_ns(), 25 * period_ns);
  EXPECT_EQ(m.applied.last_state(), switch_states[0]);
  std::array<std::int64_t, 3> times{};
  for (const GateSegment& s : m.applied.segments()) {
    for (std::size_t n = 0; n < times.size(); ++n)
      times[n] += s.state == switch_states[n] ? s.duration_ns : 0;
  }
  EXPECT_EQ(times, (std::array<std::int64_t, 3>{9 * period_ns, 8 * period_ns, 8 * period_ns}));
  EXPECT_EQ(assembler.counters().overfull, 0U);
}

TEST_F(MeasurementAssemblerTest, MoreStatesThanAPatternHoldsAreNotPlausible) {
  for (int n = 0; n < 8; ++n) assembler.add(record(state(n)));
  EXPECT_TRUE(assembler.take(0).plausible);
  for (int n = 0; n < 8; ++n) assembler.add(record(state(n)));
  assembler.add(record({gates_off, period_ns}));
  EXPECT_FALSE(assembler.take(0).plausible);
  assembler.add(record(state(1)));
  EXPECT_TRUE(assembler.take(0).plausible) << "and it heals";
  EXPECT_EQ(assembler.counters().overfull, 1U);
}

TEST_F(MeasurementAssemblerTest, NothingNewIsNoTimeInTheStateInForce) {
  assembler.add(record(state(3)));
  (void)assembler.take(0);
  const Measurement<double> m = assembler.take(period_ns);
  EXPECT_TRUE(m.plausible);
  EXPECT_EQ(m.applied, (GatePattern{switch_states[3], 0}));
  EXPECT_EQ(m.i_abc.a, 1.0);
}

TEST_F(MeasurementAssemblerTest, APlantThatNeverCameOrTimedOutIsNotPlausible) {
  EXPECT_FALSE(assembler.take(5).plausible);
  EXPECT_TRUE(assembler.timed_out());
  assembler.add(record(state(0)));
  EXPECT_TRUE(assembler.take(10).plausible);
  EXPECT_TRUE(assembler.take(10 + measurement_timeout_ns).plausible);
  EXPECT_FALSE(assembler.take(11 + measurement_timeout_ns).plausible);
  EXPECT_TRUE(assembler.timed_out());
  assembler.add(record(state(0)));
  EXPECT_TRUE(assembler.take(20 + measurement_timeout_ns).plausible);
  EXPECT_EQ(assembler.counters().timeouts, 1U) << "the wait before the first one is no silence";
}

TEST_F(MeasurementAssemblerTest, FrozenCurrentsAreNotPlausibleAfterAFewPeriods) {
  for (int round = 0; round < 3; ++round) {
    assembler.add(record(state(1)));
    EXPECT_TRUE(assembler.take(0).plausible) << "and it heals";
    for (int n = 1; n < missing_periods; ++n) EXPECT_TRUE(assembler.take(n).plausible) << n;
    EXPECT_FALSE(assembler.take(missing_periods).plausible);
    EXPECT_FALSE(assembler.take(missing_periods + 1).plausible);
    EXPECT_FALSE(assembler.timed_out()) << "late, not yet silent";
  }
  EXPECT_EQ(assembler.counters().late, 3U);
  EXPECT_EQ(assembler.counters().timeouts, 0U);
}

TEST_F(MeasurementAssemblerTest, ADriveThatWasLateItselfDoesNotBlameThePlant) {
  assembler.add(record(state(1)));
  (void)assembler.take(0);
  const std::int64_t late_ns = measurement_timeout_ns - 1;  // far more periods than may be missing
  EXPECT_TRUE(assembler.take(late_ns).plausible);
  assembler.add(record(state(1)));
  EXPECT_TRUE(assembler.take(2 * late_ns).plausible);
  EXPECT_EQ(assembler.counters().late, 0U);
}

TEST_F(MeasurementAssemblerTest, BeforeThePlantHasComeNothingIsMissing) {
  for (int n = 0; n < 3 * missing_periods; ++n) EXPECT_FALSE(assembler.take(n).plausible);
  assembler.add(record(state(1)));
  EXPECT_TRUE(assembler.take(100).plausible);
  EXPECT_EQ(assembler.counters().late, 0U);
}

TEST_F(MeasurementAssemblerTest, AMissingRecordIsNotPlausible) {
  assembler.add(record(state(0)));
  (void)record(state(1));
  (void)record(state(1));
  assembler.add(record(state(0)));
  EXPECT_FALSE(assembler.take(0).plausible);
  EXPECT_EQ(assembler.counters().missing, 2U);
}

TEST_F(MeasurementAssemblerTest, ANewPlantIsNotPlausibleOnceAndForgetsTheOldOne) {
  assembler.add(record(state(0)));
  (void)assembler.take(0);
  assembler.add(record(state(1)));
  generation = 2;
  sequence = 0;
  assembler.add(record(state(2)));
  const Measurement<double> m = assembler.take(0);
  EXPECT_FALSE(m.plausible);
  EXPECT_EQ(m.applied, state(2));
  assembler.add(record(state(2)));
  EXPECT_TRUE(assembler.take(0).plausible);
  EXPECT_EQ(assembler.counters().restarts, 1U);
}

TEST_F(MeasurementAssemblerTest, AMeasurementMarkedByThePlantIsNotPlausible) {
  MeasurementRecord r = record(state(0));
  r.plausible = 0;
  assembler.add(r);
  EXPECT_FALSE(assembler.take(0).plausible);
  MeasurementRecord bad = record(state(0));
  bad.applied.legs[0] = 0xFF;
  assembler.add(bad);
  EXPECT_FALSE(assembler.take(0).plausible);
}

// The way to the plant is cut, that back is not.
TEST_F(MeasurementAssemblerTest, APlantThatTakesNoPatternOfTheDriveIsNotPlausible) {
  for (const std::uint64_t stands_at : {std::uint64_t{0}, std::uint64_t{1000}, std::uint64_t{99'999}}) {
    SCOPED_TRACE(stands_at);  // no drive, the one before this one, one with other numbers
    taken = stands_at;
    assembler = MeasurementAssembler{{measurement_timeout_ns, missing_periods, unacknowledged_periods}};
    EXPECT_TRUE(period(state(0), state(0)).plausible) << "nothing was written that it could have taken";
    for (int n = 1; n < unacknowledged_periods; ++n) EXPECT_TRUE(period(state(0), state(0)).plausible) << n;
    for (int n = 0; n < 30; ++n) EXPECT_FALSE(period(state(0), state(0)).plausible) << n;
    EXPECT_TRUE(assembler.unacknowledged());
    EXPECT_FALSE(assembler.timed_out()) << "it is there";
    EXPECT_EQ(assembler.counters().unacknowledged, 1U);
    taken = number;
    EXPECT_TRUE(period(state(0), state(0)).plausible) << "and it heals";
    EXPECT_FALSE(assembler.unacknowledged());
  }
}

TEST_F(MeasurementAssemblerTest, APlantThatTakesPatternsLateIsPlausibleHoweverLongTheWay) {
  for (int n = 0; n < 200; ++n) {
    constexpr int way = unacknowledged_periods - 1;
    if (n >= way) taken = number - way + 1;
    EXPECT_TRUE(period(state(1), state(1)).plausible) << n;
  }
  EXPECT_EQ(assembler.counters().unacknowledged, 0U);
}

TEST_F(MeasurementAssemblerTest, NoMeasurementIsNoWordOfThePlantAboutPatterns) {
  (void)period(state(1), state(1));
  for (int n = 0; n < 3 * unacknowledged_periods; ++n) {
    assembler.wrote(++number, true);
    (void)assembler.take(plant_ns);
  }
  EXPECT_FALSE(assembler.unacknowledged());
}

TEST_F(MeasurementAssemblerTest, GatesOffAgainstADrivenPatternThatThePlantAcknowledgedAreNotPlausible) {
  const GatePattern open{gates_off, period_ns};
  for (int n = 0; n < 20; ++n) {
    taken = number;
    EXPECT_TRUE(period(open, open).plausible) << "the drive wants no other";
  }
  taken = number;
  EXPECT_TRUE(period(state(1), open).plausible) << "it has taken an open pattern";
  taken = number;
  EXPECT_FALSE(period(state(1), open).plausible) << "it has taken a driven one";
  EXPECT_EQ(assembler.counters().refused, 1U);
  taken = number;
  EXPECT_TRUE(period(open, state(1)).plausible);
  taken = number;
  EXPECT_TRUE(period(open, open).plausible);
  EXPECT_EQ(assembler.counters().refused, 1U);
}

TEST_F(MeasurementAssemblerTest, GatesOffBecauseOfALatePatternAreNoRefusal) {
  const GatePattern open{gates_off, period_ns};
  taken = 0;
  (void)period(state(1), open);
  for (int round = 0; round < 5; ++round) {
    taken = number;
    EXPECT_TRUE(period(state(1), state(1)).plausible);
    for (int n = 0; n < 3; ++n) EXPECT_TRUE(period(state(1), open).plausible) << "nothing newer was taken";
  }
  GatePattern opened_in_between{switch_states[1], period_ns / 2};
  opened_in_between.append({gates_off, period_ns / 2});
  taken = number;
  EXPECT_TRUE(period(state(1), opened_in_between).plausible);
  EXPECT_EQ(assembler.counters().refused, 0U);
}

TEST(AssemblerParameters, ADriveWaitsForAnAnswerAsLongAsThePlantWaitsForAPattern) {
  HilParameters p;
  p.pattern_timeout_ns = 5'000'000;
  p.missing_periods = 4;
  EXPECT_EQ(assembler_parameters(p, 100'000).unacknowledged_periods, 50);
  EXPECT_EQ(assembler_parameters(p, 300'000).unacknowledged_periods, 17);
  p.missing_periods = 80;
  EXPECT_EQ(assembler_parameters(p, 100'000).unacknowledged_periods, 80)
      << "not stricter than about measurements";
  EXPECT_EQ(assembler_parameters(p, 100'000).missing_periods, 80);
  EXPECT_EQ(assembler_parameters(p, 100'000).measurement_timeout_ns, p.measurement_timeout_ns);
}

}  // namespace
}  // namespace sextant
