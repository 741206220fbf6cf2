#include "sextant/hil/measurement_assembler.hpp"

#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 100'000;
constexpr std::int64_t stale_ns = 1'000'000;
constexpr int missing_periods = 4;

GatePattern state(int vector, std::int32_t duration_ns = period_ns) {
  return {switch_states[std::size_t(vector)], duration_ns};
}

class MeasurementAssemblerTest : public testing::Test {
 protected:
  MeasurementRecord record(const GatePattern& acted) {
    Measurement<double> m{
        .t_ns = plant_ns += acted.duration_ns(), .i_abc = {1, 2, -3}, .u_dc = 530, .acted = acted};
    m.omega_m = double(sequence);
    MeasurementRecord r = to_record(m);
    r.generation = generation;
    r.sequence = ++sequence;
    return r;
  }

  MeasurementAssembler assembler{{.stale_ns = stale_ns, .missing_periods = missing_periods}};
  std::uint64_t sequence{0};
  std::uint32_t generation{1};
  std::int64_t plant_ns{0};
};

TEST_F(MeasurementAssemblerTest, JoinsWhatActedAndTakesTheNewestValues) {
  assembler.add(record(state(1)));
  (void)assembler.take(0);
  assembler.add(record(state(1)));
  assembler.add(record(state(1)));
  assembler.add(record(state(2)));
  const Measurement<double> m = assembler.take(1000);
  EXPECT_TRUE(m.plausible);
  EXPECT_EQ(m.t_ns, 1000);
  EXPECT_EQ(m.omega_m, 3.0);
  EXPECT_EQ(m.i_abc.c, -3.0);
  GatePattern expected{switch_states[1], 2 * period_ns};
  expected.append({switch_states[2], period_ns});
  EXPECT_EQ(m.acted, expected);
  EXPECT_TRUE(m.acted.is_driven());
}

TEST_F(MeasurementAssemblerTest, RandomPatternsKeepTheirOrderAndDuration) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  for (int round = 0; round < 2000; ++round) {
    std::vector<SwitchState> nanoseconds;  // the state of each
    for (auto n = random() % 4; n > 0; --n) {
      GatePattern acted;
      for (auto k = random() % 3 + 1; k > 0; --k) {
        const auto duration = std::int32_t(random() % 5 + 1);
        const SwitchState s = random() % 9 == 0 ? gates_off : switch_states[random() % 2];
        acted.append({s, duration});
        nanoseconds.insert(nanoseconds.end(), std::size_t(duration), s);
      }
      assembler.add(record(acted));
    }
    const Measurement<double> m = assembler.take(0);
    if (!m.plausible) continue;  // more changes than a pattern holds, or none yet
    std::vector<SwitchState> joined;
    for (const GateSegment& s : m.acted.segments()) {
      joined.insert(joined.end(), std::size_t(s.duration_ns), s.state);
    }
    ASSERT_EQ(joined, nanoseconds) << "round " << round;
  }
}

TEST_F(MeasurementAssemblerTest, MoreChangesThanAPatternHoldsAreNotPlausible) {
  for (int n = 0; n < 8; ++n) assembler.add(record(state(n % 2)));
  EXPECT_TRUE(assembler.take(0).plausible);
  for (int n = 0; n < 9; ++n) assembler.add(record(state(n % 2)));
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
  EXPECT_EQ(m.acted, (GatePattern{switch_states[3], 0}));
  EXPECT_EQ(m.i_abc.a, 1.0);
}

TEST_F(MeasurementAssemblerTest, APlantThatNeverCameOrFellSilentIsNotPlausible) {
  EXPECT_FALSE(assembler.take(5).plausible);
  EXPECT_TRUE(assembler.stale());
  assembler.add(record(state(0)));
  EXPECT_TRUE(assembler.take(10).plausible);
  EXPECT_TRUE(assembler.take(10 + stale_ns).plausible);
  EXPECT_FALSE(assembler.take(11 + stale_ns).plausible);
  EXPECT_TRUE(assembler.stale());
  assembler.add(record(state(0)));
  EXPECT_TRUE(assembler.take(20 + stale_ns).plausible);
  EXPECT_EQ(assembler.counters().stale, 1U) << "the wait before the first one is no silence";
}

TEST_F(MeasurementAssemblerTest, FrozenCurrentsAreNotPlausibleAfterAFewPeriods) {
  for (int round = 0; round < 3; ++round) {
    assembler.add(record(state(1)));
    EXPECT_TRUE(assembler.take(0).plausible) << "and it heals";
    for (int n = 1; n < missing_periods; ++n) EXPECT_TRUE(assembler.take(n).plausible) << n;
    EXPECT_FALSE(assembler.take(missing_periods).plausible);
    EXPECT_FALSE(assembler.take(missing_periods + 1).plausible);
    EXPECT_FALSE(assembler.stale()) << "late, not yet silent";
  }
  EXPECT_EQ(assembler.counters().late, 3U);
  EXPECT_EQ(assembler.counters().stale, 0U);
}

TEST_F(MeasurementAssemblerTest, ADriveThatWasLateItselfDoesNotBlameThePlant) {
  assembler.add(record(state(1)));
  (void)assembler.take(0);
  const std::int64_t late_ns = stale_ns - 1;  // far more periods than may be missing
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
  EXPECT_EQ(m.acted, state(2));
  assembler.add(record(state(2)));
  EXPECT_TRUE(assembler.take(0).plausible);
  EXPECT_EQ(assembler.counters().restarts, 1U);
}

TEST_F(MeasurementAssemblerTest, APlantThatDoesNotVouchIsNotPlausible) {
  MeasurementRecord r = record(state(0));
  r.plausible = 0;
  assembler.add(r);
  EXPECT_FALSE(assembler.take(0).plausible);
  MeasurementRecord bad = record(state(0));
  bad.acted.legs[0] = 0xFF;
  assembler.add(bad);
  EXPECT_FALSE(assembler.take(0).plausible);
}

}  // namespace
}  // namespace sextant
