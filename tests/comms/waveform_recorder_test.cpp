#include "sextant/comms/waveform_recorder.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;

Telemetry<double> period_at(std::int64_t t_ns) {
  Telemetry<double> x;
  x.t_ns = t_ns;
  x.torque = double(t_ns) * 1e-6;
  return x;
}

/// A symmetric pattern of seven segments: V0 V1 V2 V7 V2 V1 V0.
GatePattern symmetric_pattern() {
  GatePattern pattern;
  const struct {
    int state;
    std::int32_t ns;
  } parts[] = {{0, 2000}, {1, 4000}, {2, 3000}, {7, 7000}, {2, 3000}, {1, 4000}, {0, 2000}};
  for (const auto& part : parts)
    EXPECT_TRUE(pattern.append({switch_states[std::size_t(part.state)], part.ns}));
  return pattern;
}

TEST(PatternShares, AreTimesOfTheLegsOverThePattern) {
  const PatternShares shares = shares_of(symmetric_pattern());
  EXPECT_FLOAT_EQ(shares.duty.a, 21.0F / 25.0F);  // V1, V2, V7
  EXPECT_FLOAT_EQ(shares.duty.b, 13.0F / 25.0F);  // V2, V7
  EXPECT_FLOAT_EQ(shares.duty.c, 7.0F / 25.0F);   // V7
  // 8 µs in two halves are longer than 7 in one.
  EXPECT_EQ(shares.longest, switch_states[1]);
}

TEST(PatternShares, GatesOffIsNoDuty) {
  for (const GatePattern& pattern : {GatePattern{}, GatePattern{gates_off, period_ns}}) {
    const PatternShares shares = shares_of(pattern);
    EXPECT_EQ(shares.duty.a, 0.0F);
    EXPECT_EQ(shares.longest, gates_off);
  }
}

TEST(WaveformRecorder, ABatchEndsAfter400PeriodsOr10Milliseconds) {
  for (const std::int32_t period : {5'000, 25'000, 100'000}) {
    SCOPED_TRACE(period);
    WaveformRecorder recorder{period};
    std::int64_t t_ns = 1'000'000'000;
    int periods = 0;
    for (; recorder.fits(period_at(t_ns)); t_ns += period, ++periods) recorder.add(period_at(t_ns));
    EXPECT_EQ(periods, period == 5'000 ? 400 : 10'000'000 / period);
    const WaveformBatch& batch = recorder.batch();
    EXPECT_EQ(batch.t_ns, 1'000'000'000);
    EXPECT_EQ(batch.period_ns, std::uint32_t(period));
    ASSERT_EQ(batch.offset_ns.size(), std::size_t(periods));
    for (std::size_t k = 0; k < batch.offset_ns.size(); ++k) {
      const std::int64_t at_ns = batch.t_ns + batch.offset_ns.values()[k];
      EXPECT_EQ(at_ns, 1'000'000'000 + std::int64_t(k) * period);
      EXPECT_FLOAT_EQ(batch.torque_nm.values()[k], float(at_ns) * 1e-6F);
    }
    recorder.reset();
    EXPECT_TRUE(recorder.is_empty());
    EXPECT_TRUE(recorder.fits(period_at(t_ns)));
  }
}

TEST(WaveformRecorder, MissedPeriodsAreAGapInTime) {
  WaveformRecorder recorder{period_ns};
  recorder.add(period_at(0));
  recorder.add(period_at(3 * period_ns));
  EXPECT_EQ(recorder.batch().offset_ns.values()[1], 3U * period_ns);
  EXPECT_FALSE(recorder.fits(period_at(7'200'000'000'000))) << "an hour later";
}

TEST(WaveformRecorder, EverySequenceHasOneValueAPeriod) {
  WaveformRecorder recorder{period_ns};
  Telemetry<double> x = period_at(0);
  x.pattern = GatePattern{switch_states[2], period_ns};
  x.i_abc.a = std::numeric_limits<double>::quiet_NaN();
  x.state = DriveState::torque;
  recorder.add(x);
  recorder.add(period_at(period_ns));
  std::size_t sequences = 0;
  const auto count = [&sequences]<class Member>(const Member& member) {
    if constexpr (requires { member.values(); }) {
      EXPECT_EQ(member.size(), 2U);
      ++sequences;
    }
  };
#define SEXTANT_COUNT(member, unit, text) count(recorder.batch().member);
  SEXTANT_WAVEFORM_MEMBERS(SEXTANT_COUNT)
#undef SEXTANT_COUNT
  EXPECT_EQ(sequences, 18U);
  EXPECT_EQ(recorder.batch().switch_state.values()[0], 0b000'011);
  EXPECT_EQ(recorder.batch().switch_state.values()[1], 0b111'000) << "gates off";
  EXPECT_EQ(recorder.batch().state.values()[0], std::uint8_t(DriveState::torque));
  EXPECT_TRUE(std::isnan(recorder.batch().i_a_a.values()[0]));
}

}  // namespace
}  // namespace sextant
