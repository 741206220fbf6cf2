#include "sextant/core/gate_pattern.hpp"

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(GatePattern, AnEmptyPatternMeansGatesOff) {
  const GatePattern pattern;
  EXPECT_TRUE(pattern.segments().empty());
  EXPECT_EQ(pattern.last_state(), gates_off);
  EXPECT_EQ(pattern.duration_ns(), 0);
}

TEST(GatePattern, OneStateFillsThePeriod) {
  const GatePattern pattern{switch_states[3], 25'000};
  ASSERT_EQ(pattern.segments().size(), 1U);
  EXPECT_EQ(pattern.segments()[0], (GateSegment{switch_states[3], 25'000}));
  EXPECT_EQ(pattern.last_state(), switch_states[3]);
  EXPECT_EQ(pattern.duration_ns(), 25'000);
}

TEST(GatePattern, KeepsSegmentsInOrderAndRefusesTheOneTooMany) {
  GatePattern pattern;
  std::int64_t sum = 0;
  for (unsigned i = 0; i < GatePattern::capacity; ++i) {
    EXPECT_TRUE(pattern.append({switch_states[i % 8], std::int32_t(100 + i)}));
    sum += 100 + i;
  }
  const GatePattern full = pattern;
  EXPECT_FALSE(pattern.append({gates_off, 1}));
  EXPECT_EQ(pattern, full);
  EXPECT_EQ(pattern.duration_ns(), sum);
  ASSERT_EQ(pattern.segments().size(), GatePattern::capacity);
  for (unsigned i = 0; i < GatePattern::capacity; ++i) {
    EXPECT_EQ(pattern.segments()[i].state, switch_states[i % 8]);
  }
}

TEST(GatePattern, ASegmentWithoutDurationIsLeftOut) {
  GatePattern with;
  GatePattern without;
  for (const int duration_ns : {0, 100, 0, 0, 200, 0}) {
    EXPECT_TRUE(with.append({duration_ns == 0 ? gates_off : switch_states[2], duration_ns}));
    if (duration_ns > 0) without.append({switch_states[2], duration_ns});
  }
  EXPECT_EQ(with, without);
  EXPECT_TRUE(with.is_driven());
  EXPECT_EQ(with.last_state(), switch_states[2]);
}

TEST(GatePattern, AStateWithoutDurationGivesWayToTheNextSegment) {
  GatePattern pattern;
  EXPECT_TRUE(pattern.append({gates_off, 0}));
  EXPECT_EQ(pattern, (GatePattern{gates_off, 0})) << "one rule for both ways to make it";
  EXPECT_EQ(pattern.segments().size(), 1U) << "no time has passed, in a known state";
  EXPECT_TRUE(pattern.append({switch_states[1], 0}));
  EXPECT_EQ(pattern, (GatePattern{switch_states[1], 0})) << "the later state is in force";
  pattern = {gates_off, 0};
  EXPECT_TRUE(pattern.append({switch_states[2], 100}));
  EXPECT_EQ(pattern, (GatePattern{switch_states[2], 100}));
  EXPECT_TRUE(pattern.is_driven());
  pattern = {switch_states[2], 0};
  EXPECT_TRUE(pattern.append({gates_off, 100}));
  EXPECT_EQ(pattern, (GatePattern{gates_off, 100}));
  EXPECT_FALSE(pattern.is_driven());
}

TEST(GatePattern, AFullPatternTakesASegmentWithoutDuration) {
  GatePattern pattern;
  for (unsigned i = 0; i < GatePattern::capacity; ++i) pattern.append({switch_states[i % 8], 1});
  EXPECT_TRUE(pattern.append({gates_off, 0}));
  EXPECT_TRUE(pattern.is_driven());
}

TEST(GatePattern, DurationsLongerThanTwoSecondsDoNotOverflow) {
  GatePattern pattern;
  pattern.append({switch_states[0], 2'000'000'000});
  pattern.append({switch_states[7], 2'000'000'000});
  EXPECT_EQ(pattern.duration_ns(), 4'000'000'000);
}

}  // namespace
}  // namespace sextant
