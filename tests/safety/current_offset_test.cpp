#include "sextant/safety/current_offset.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sextant/safety/protection.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr int average_periods = 800;  // 20 ms
constexpr int rest_periods = 400;     // 10 ms

template <class T>
class CurrentOffsetOf : public testing::Test {
 protected:
  [[nodiscard]] static Measurement<T> reading(T a, T b, T c, SwitchState state = gates_off) {
    Measurement<T> m;
    m.i_abc = {a, b, c};
    m.u_dc = T(530);
    m.applied = GatePattern{state, period_ns};
    return m;
  }
  void run(const Measurement<T>& m, int periods) {
    for (int k = 0; k < periods; ++k) offset.step(m);
  }

  [[nodiscard]] ThreePhase<T> removed() const {
    const ThreePhase<T> left = offset.removed_from(reading(T(0), T(0), T(0))).i_abc;
    return {-left.a, -left.b, -left.c};
  }
  [[nodiscard]] static double uniform(std::mt19937& dice, double from, double to) {
    return std::uniform_real_distribution<double>{from, to}(dice);
  }
  [[nodiscard]] static double noise(std::mt19937& dice) {
    return std::normal_distribution<double>{0, 0.2}(dice);
  }

  static constexpr T limit = T(0.58);
  CurrentOffset<T> offset{{.limit = limit}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CurrentOffsetOf, Scalars);

TYPED_TEST(CurrentOffsetOf, IsTheMeanReadingWithTheGatesOff) {
  using T = TypeParam;
  for (int k = 0; k < average_periods; ++k) {
    const T noise = k % 2 == 0 ? T(0.3) : T(-0.3);
    this->offset.step(this->reading(T(0.4) + noise, T(-0.5) - noise, T(0)));
  }
  const ThreePhase<T> i = this->offset.removed_from(this->reading(T(10), T(-10), T(0))).i_abc;
  EXPECT_NEAR(i.a, T(9.6), T(1e-3));
  EXPECT_NEAR(i.b, T(-9.5), T(1e-3));
  EXPECT_EQ(i.c, T(0));
  EXPECT_NEAR(this->offset.largest(), T(0.5), T(1e-3));
}

TYPED_TEST(CurrentOffsetOf, BeyondItsLimitIsSeenAndRemovedUpToIt) {
  using T = TypeParam;
  const Measurement<T> m = this->reading(T(-1.5), T(0), T(0.3));
  this->run(m, average_periods - 1);
  EXPECT_EQ(this->offset.largest(), T(0)) << "the mean does not span its time yet";
  this->run(m, 1);
  EXPECT_NEAR(this->offset.largest(), T(1.5), T(1e-4));
  EXPECT_NEAR(this->offset.removed_from(m).i_abc.a, T(-1.5) + this->limit, T(1e-6));
}

TYPED_TEST(CurrentOffsetOf, HoldsWhileTheGatesAreOnAndUntilTheReadingsStandStill) {
  using T = TypeParam;
  this->run(this->reading(T(0.2), T(0), T(0)), average_periods);
  this->run(this->reading(T(100), T(-50), T(-50), switch_states[1]), 1000);
  EXPECT_NEAR(this->offset.largest(), T(0.2), T(1e-4));
  this->run(this->reading(T(0.3), T(0), T(0)), rest_periods - 1);
  EXPECT_NEAR(this->removed().a, T(0.2), T(1e-4)) << "until the readings have stood still for 10 ms";
  this->run(this->reading(T(0.3), T(0), T(0)), 1);
  EXPECT_NEAR(this->removed().a, T(0.3), T(1e-4));
  this->run(this->reading(T(0.3), T(0), T(0)), average_periods - rest_periods);
  EXPECT_NEAR(this->offset.largest(), T(0.3), T(1e-3));
}

// Currents of a machine that turns and is not excited: from slow machines to fast ones, of a fraction of the
// limit to hundreds of amperes.
TYPED_TEST(CurrentOffsetOf, IsNotThatOfCurrentsThatTurnAndDecay) {
  using T = TypeParam;
  std::mt19937 dice{20'241};
  for (int n = 0; n < 200; ++n) {
    const double omega =
        2 * std::numbers::pi * std::exp(this->uniform(dice, std::log(25.0), std::log(1000.0)));
    const double tau = std::exp(this->uniform(dice, std::log(3e-3), std::log(0.5)));
    const double peak = std::exp(this->uniform(dice, std::log(0.3), std::log(300.0)));
    const double angle = this->uniform(dice, 0, 2 * std::numbers::pi);
    SCOPED_TRACE(testing::Message() << n << ": " << omega << " rad/s, " << tau << " s, " << peak << " A");
    this->offset.restart();
    for (double t = 0; t < 5 * tau; t += 1e-9 * period_ns) {
      const double i = peak * std::exp(-t / tau);
      const auto phase = [&](double shift) {
        return T(i * std::cos(angle + omega * t + shift) + this->noise(dice));
      };
      this->offset.step(this->reading(phase(0), phase(-2.0944), phase(2.0944)));
      ASSERT_LE(this->offset.largest(), this->limit) << "after " << t << " s";
    }
  }
}

// A sensor that is broken all the same. A run that begins with the last of the currents, within the band, may
// have to begin again.
TYPED_TEST(CurrentOffsetOf, BeyondItsLimitIsSeenWithin45MsOfTheEndOfTheCurrents) {
  using T = TypeParam;
  std::mt19937 dice{20'242};
  for (int n = 0; n < 100; ++n) {
    const double omega = 2 * std::numbers::pi * this->uniform(dice, 25, 500);
    const double end = this->uniform(dice, 0, 0.1);
    const double broken = this->uniform(dice, 1.1, 30) * double(this->limit) * (n % 2 == 0 ? 1 : -1);
    SCOPED_TRACE(testing::Message() << n << ": " << omega << " rad/s until " << end << " s, " << broken
                                    << " A");
    this->offset.restart();
    for (double t = 0; t < end + 0.045; t += 1e-9 * period_ns) {
      const double i = t < end ? 50 * (1 - t / end) : 0;
      const auto phase = [&](double shift) { return T(i * std::cos(omega * t + shift) + this->noise(dice)); };
      this->offset.step(this->reading(phase(0) + T(broken), phase(-2.0944), phase(2.0944)));
    }
    EXPECT_GT(this->offset.largest(), this->limit);
  }
}

TYPED_TEST(CurrentOffsetOf, AReadingThatIsRepeatedCountsForNothing) {
  using T = TypeParam;
  Measurement<T> repeated = this->reading(T(0.5), T(0), T(0));
  repeated.applied = GatePattern{};
  this->run(repeated, average_periods);
  EXPECT_EQ(this->removed().a, T(0));
  EXPECT_EQ(this->offset.largest(), T(0));
}

// What flows after the gates went off is no offset: at power-up alone the first reading counts at once.
TYPED_TEST(CurrentOffsetOf, AfterAFaultIsThatOfReadingsAtRest) {
  using T = TypeParam;
  const Measurement<T> m = this->reading(T(0.4), T(0), T(0));
  this->run(m, 1);
  EXPECT_NEAR(this->removed().a, T(0.4), T(1e-6));
  this->offset.restart();
  this->run(m, rest_periods - 1);
  EXPECT_EQ(this->removed().a, T(0));
  this->run(m, 1);
  EXPECT_NEAR(this->removed().a, T(0.4), T(1e-5));
}

TYPED_TEST(CurrentOffsetOf, ForgetsAWildReading) {
  using T = TypeParam;
  this->run(this->reading(T(0), T(0), T(0)), average_periods);
  this->run(this->reading(T(1e30), T(0), T(-1e30)), 10 * average_periods);
  EXPECT_GT(this->offset.largest(), this->limit);
  this->run(this->reading(T(0), T(0), T(0)), 1200);
  EXPECT_LT(this->offset.largest(), this->limit) << "after 30 ms";
  // One within a run, as of a converter that drops a sample.
  this->run(this->reading(T(1e30), T(0), T(-1e30)), 1);
  this->run(this->reading(T(0), T(0), T(0)), rest_periods);
  EXPECT_EQ(this->removed().a, T(0));
}

TYPED_TEST(CurrentOffsetOf, BeyondItsLimitIsAFaultOfASensorInEachPhaseAndSign) {
  using T = TypeParam;
  FaultSet expected;
  expected.set(Fault::current_sensor);
  for (const auto phase : {&ThreePhase<T>::a, &ThreePhase<T>::b, &ThreePhase<T>::c}) {
    for (const T sign : {T(-1), T(1)}) {
      const auto run = [&](T mean) {
        Protection<T> protection{typename Protection<T>::Parameters{.current_offset = this->limit}};
        Measurement<T> m = this->reading(T(0), T(0), T(0));
        m.i_abc.*phase = sign * mean;
        FaultSet faults;
        for (int k = 0; k < average_periods; ++k) faults = protection.step(m);
        return faults;
      };
      EXPECT_FALSE(run(T(0.57)).any());
      EXPECT_EQ(run(T(0.59)), expected);
    }
  }
}

}  // namespace
}  // namespace sextant
