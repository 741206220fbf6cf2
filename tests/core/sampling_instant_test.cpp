#include "sextant/core/sampling_instant.hpp"

#include <array>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 1000;

/// Time in each state. [ns]
using Times = std::array<std::int64_t, 8>;
void add(Times& times, const GatePattern& pattern) {
  for (const GateSegment& segment : pattern.segments()) {
    times[segment.state.upper_switches()] += segment.duration_ns;
  }
}

/// Symmetric, as of a space-vector modulation.
GatePattern random_pattern(std::mt19937& generator) {
  std::uniform_int_distribution<int> vector{1, 6};
  std::uniform_int_distribution<int> time{1, 150};
  const SwitchState first = switch_states[std::size_t(vector(generator))];
  const SwitchState second = switch_states[std::size_t(vector(generator))];
  const int a = time(generator);
  const int b = time(generator);
  const int zero = time(generator);
  GatePattern pattern;
  for (const GateSegment segment : {GateSegment{switch_states[0], zero},
                                    {first, a},
                                    {second, b},
                                    {switch_states[7], period_ns - 2 * (zero + a + b)},
                                    {second, b},
                                    {first, a},
                                    {switch_states[0], zero}}) {
    pattern.append(segment);
  }
  return pattern;
}

TEST(SamplingInstant, ThePatternsBetweenSamplesAreThoseOfThePeriodsEarlierByTheLead) {
  for (const std::int32_t lead_ns : {1, 200, 500, 999, 1000}) {
    SCOPED_TRACE(lead_ns);
    std::mt19937 generator{20261125};
    SamplingInstant<> sampling{lead_ns};
    Times applied{};
    Times between{};
    for (int period = 0; period < 200; ++period) {
      Measurement<> m;
      m.applied = random_pattern(generator);
      add(applied, m.applied);
      const Measurement<>& sampled = sampling.step(m);
      EXPECT_EQ(sampled.applied.duration_ns(), period == 0 ? period_ns - lead_ns : period_ns);
      EXPECT_TRUE(lead_ns == period_ns || sampled.applied.is_driven());
      EXPECT_EQ(sampling.since().duration_ns(), lead_ns);
      add(between, sampled.applied);
      Times all = between;
      add(all, sampling.since());
      ASSERT_EQ(all, applied) << "period " << period;
    }
  }
}

TEST(SamplingInstant, TheOrderOfTheStatesStays) {
  SamplingInstant<> sampling{500};
  Measurement<> m;
  for (const GateSegment segment : {GateSegment{switch_states[0], 100},
                                    {switch_states[1], 250},
                                    {switch_states[7], 300},
                                    {switch_states[1], 250},
                                    {switch_states[0], 100}}) {
    m.applied.append(segment);
  }
  (void)sampling.step(m);
  GatePattern expected;
  for (const GateSegment segment : {GateSegment{switch_states[7], 150},
                                    {switch_states[1], 250},
                                    {switch_states[0], 200},
                                    {switch_states[1], 250},
                                    {switch_states[7], 150}}) {
    expected.append(segment);
  }
  EXPECT_EQ(sampling.step(m).applied, expected);
}

TEST(SamplingInstant, TheOrderStaysInAFullPattern) {
  SamplingInstant<> sampling{100};
  Measurement<> m;
  for (std::size_t k = 0; k < GatePattern::capacity; ++k) m.applied.append({switch_states[k % 2], 100});
  (void)sampling.step(m);
  GatePattern expected;
  for (std::size_t k = 0; k < GatePattern::capacity; ++k) expected.append({switch_states[(k + 1) % 2], 100});
  EXPECT_EQ(sampling.step(m).applied, expected);
}

TEST(SamplingInstant, WithoutALeadAMeasurementIsAsItIs) {
  SamplingInstant<> sampling{0};
  Measurement<> m;
  m.i_abc = {1, 2, -3};
  m.applied = GatePattern{switch_states[2], period_ns};
  EXPECT_EQ(&sampling.step(m), &m);
  EXPECT_TRUE(sampling.since().segments().empty());
}

TEST(SamplingInstant, APeriodWithoutANewMeasurementMovesNothing) {
  SamplingInstant<> sampling{400};
  Measurement<> m;
  m.applied = GatePattern{switch_states[2], period_ns};
  (void)sampling.step(m);
  Measurement<> repeated;
  repeated.applied = GatePattern{switch_states[2], 0};
  EXPECT_EQ(sampling.step(repeated).applied.duration_ns(), 0);
  EXPECT_EQ(sampling.since().duration_ns(), 400);
}

TEST(SamplingInstant, APartWithGatesOffIsToldInTheSampleThatItReaches) {
  SamplingInstant<> sampling{400};
  Measurement<> m;
  m.applied.append({switch_states[2], 700});
  m.applied.append({gates_off, 300});
  EXPECT_TRUE(sampling.step(m).applied.is_driven());
  EXPECT_FALSE(sampling.since().is_driven());
  m.applied = GatePattern{switch_states[2], period_ns};
  EXPECT_FALSE(sampling.step(m).applied.is_driven());
  EXPECT_TRUE(sampling.since().is_driven());
}

}  // namespace
}  // namespace sextant
