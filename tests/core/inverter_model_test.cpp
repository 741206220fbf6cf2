#include "sextant/core/inverter_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double u_dc = 530.0;
constexpr double leakage = 4.7e-3;
constexpr std::int32_t period_ns = 25'000;
constexpr std::int32_t dead_ns = 1'500;
constexpr double lost = u_dc * dead_ns * 1e-9;  // of one edge [V·s]

/// Legs a, b, c rise one after the other and fall in the opposite order.
GatePattern modulated() {
  GatePattern p;
  const std::size_t order[]{0, 1, 2, 7, 2, 1, 0};
  const std::int32_t times[]{4'000, 3'000, 3'000, 5'000, 3'000, 3'000, 4'000};
  for (std::size_t n = 0; n < 7; ++n) p.append({switch_states[order[n]], times[n]});
  return p;
}

template <class T>
class InverterModelOf : public testing::Test {
 protected:
  using Model = InverterModel<T>;

  /// What the model adds over the pattern under currents that end as they begin, large against their ripple.
  static ThreePhase<T> beyond(const typename Model::Parameters& parameters, const GatePattern& pattern,
                              const ThreePhase<T>& i) {
    Model model{parameters, T(leakage)};
    (void)model.step({switch_states[0], period_ns}, i, T(u_dc));
    return model.step(pattern, i, T(u_dc));
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(InverterModelOf, Scalars);

TYPED_TEST(InverterModelOf, WithoutDeadTimeAndDropsNothingIsAdded) {
  using T = TypeParam;
  EXPECT_EQ(this->beyond({}, modulated(), {T(20), T(-8), T(-12)}), ThreePhase<T>{});
}

// A leg that is modulated loses sign(i_x) u_dc t_d a period; the star point takes the mean of the three.
TYPED_TEST(InverterModelOf, AModulatedLegLosesTheLinkVoltageForOneDeadTimeInTheDirectionOfItsCurrent) {
  using T = TypeParam;
  for (const double sign : {1.0, -1.0}) {
    const ThreePhase<T> i{T(sign * 20), T(-sign * 8), T(-sign * 12)};
    const ThreePhase<T> v = this->beyond({.dead_time_ns = dead_ns}, modulated(), i);
    EXPECT_NEAR(double(v.a), -sign * lost * 4.0 / 3.0, 1e-4 * lost);
    EXPECT_NEAR(double(v.b), sign * lost * 2.0 / 3.0, 1e-4 * lost);
    EXPECT_NEAR(double(v.c), sign * lost * 2.0 / 3.0, 1e-4 * lost);
  }
}

// All three legs in their dead time at once, with currents that stop and flow again: in one part or in eight.
class SizeOfCurrents : public testing::TestWithParam<double> {};

TEST_P(SizeOfCurrents, ADeadTimeIsTheSameInOnePartAndInMany) {
  std::mt19937 random{4711};
  SCOPED_TRACE("seed 4711");
  std::normal_distribution<double> amperes{0.0, GetParam()};
  const InverterModel<double> model{{.dead_time_ns = dead_ns}, leakage};
  int unlike = 0;
  for (int n = 0; n < 2000; ++n) {
    const SpaceVector<double> begin{amperes(random), amperes(random)};
    const SpaceVector<double> end{begin.alpha + amperes(random), begin.beta + amperes(random)};
    const auto beyond = [&](int parts) {
      GatePattern pattern;
      for (int k = 0; k < parts; ++k) pattern.append({switch_states[7], 2'000 / parts});
      InverterModel<double>::Legs legs{.commanded = switch_states[0]};
      return model.predicted(pattern, begin, end, u_dc, legs);
    };
    const ThreePhase<double> whole = beyond(1);
    const ThreePhase<double> parted = beyond(8);
    const double off =
        std::max({std::abs(whole.a - parted.a), std::abs(whole.b - parted.b), std::abs(whole.c - parted.c)});
    EXPECT_LT(off, 1e-6 * lost) << n;
    unlike += off > 1e-3 * lost ? 1 : 0;
  }
  EXPECT_EQ(unlike, 0);
}

// Currents that a dead time stops at once, within it, at its end, and not at all.
INSTANTIATE_TEST_SUITE_P(InverterModel, SizeOfCurrents, testing::Values(0.003, 0.03, 0.3, 3.0));

// Readings that cannot be are kept from the drive elsewhere; here they may not end the program.
TEST(InverterModel, ALinkThatReadsBelowZeroIsNone) {
  InverterModel<double> model{{.dead_time_ns = dead_ns}, leakage};
  for (int n = 0; n < 3; ++n) {
    const ThreePhase<double> v = model.step(modulated(), {0, 0, 0}, -5.0);
    EXPECT_TRUE(std::isfinite(v.a + v.b + v.c));
  }
}

TYPED_TEST(InverterModelOf, AnEdgeCountsByItsDirectionAndTheCurrent) {
  using T = TypeParam;
  GatePattern rises{switch_states[0], 10'000};
  rises.append({switch_states[1], 15'000});
  const auto of_a = [&](double i) {
    return double(this->beyond({.dead_time_ns = dead_ns}, rises, {T(i), T(-i / 2), T(-i / 2)}).a);
  };
  EXPECT_NEAR(of_a(20), -lost * 2.0 / 3.0, 1e-4 * lost);
  EXPECT_NEAR(of_a(-20), 0.0, 1e-4 * lost);
}

TYPED_TEST(InverterModelOf, ADeadTimeGoesOnInTheNextPeriod) {
  using T = TypeParam;
  InverterModel<T> model{{.dead_time_ns = dead_ns}, T(leakage)};
  const ThreePhase<T> i{T(20), T(-10), T(-10)};
  (void)model.step({switch_states[0], period_ns}, i, T(u_dc));
  GatePattern late{switch_states[0], period_ns - 500};
  late.append({switch_states[1], 500});
  EXPECT_NEAR(double(model.step(late, i, T(u_dc)).a), -lost * 2.0 / 3.0 / 3.0, 1e-4 * lost);
  EXPECT_EQ(model.legs().dead_ns[0], 1'000);
  EXPECT_NEAR(double(model.step({switch_states[1], period_ns}, i, T(u_dc)).a), -lost * 2.0 / 3.0 * 2.0 / 3.0,
              1e-4 * lost);
}

// At a current of zero between two zero vectors without EMF nothing drives one: the potentials of the three
// legs stay equal, whatever they are.
TYPED_TEST(InverterModelOf, WithoutCurrentNothingIsLost) {
  using T = TypeParam;
  GatePattern p{switch_states[0], 10'000};
  p.append({switch_states[7], 15'000});
  const ThreePhase<T> v = this->beyond({.dead_time_ns = dead_ns}, p, {});
  EXPECT_NEAR(double(v.a), 0.0, 1e-5 * lost);
  EXPECT_NEAR(double(v.b), 0.0, 1e-5 * lost);
  EXPECT_NEAR(double(v.c), 0.0, 1e-5 * lost);
}

// The current of leg a passes through zero in the period: the edges on both sides of it count by their own
// sign.
TYPED_TEST(InverterModelOf, TheSignFollowsTheCurrentBetweenTheReadings) {
  using T = TypeParam;
  InverterModel<T> model{{.dead_time_ns = dead_ns}, T(leakage)};
  GatePattern p{switch_states[0], 5'000};
  p.append({switch_states[7], 15'000});
  p.append({switch_states[0], 5'000});
  (void)model.step({switch_states[0], period_ns}, {T(-30), T(15), T(15)}, T(u_dc));
  // From −30 A to 30 A: negative at the rising edge, positive at the falling one, neither of which costs leg
  // a; b and c lose u_dc t_d at the rising edge and gain as much at the falling one.
  const ThreePhase<T> v = model.step(p, {T(30), T(-15), T(-15)}, T(u_dc));
  EXPECT_NEAR(double(v.a), 0.0, 1e-3 * lost);
  EXPECT_NEAR(double(v.b), 0.0, 1e-3 * lost);
}

TYPED_TEST(InverterModelOf, DropsActAgainstTheCurrent) {
  using T = TypeParam;
  const ThreePhase<T> i{T(20), T(-8), T(-12)};
  const ThreePhase<T> v =
      this->beyond({.threshold_voltage = T(1.2), .slope_resistance = T(0.02)}, modulated(), i);
  const double seconds = period_ns * 1e-9;
  const double common = (1.2 - 1.2 - 1.2) / 3.0;  // the currents add up to zero
  EXPECT_NEAR(double(v.a), -seconds * (1.2 - common + 0.02 * 20), 1e-3 * seconds);
  EXPECT_NEAR(double(v.b), seconds * (1.2 + common + 0.02 * 8), 1e-3 * seconds);
  EXPECT_NEAR(double(v.c), seconds * (1.2 + common + 0.02 * 12), 1e-3 * seconds);
}

TYPED_TEST(InverterModelOf, WhatIsPredictedIsWhatThenIsMeasured) {
  using T = TypeParam;
  const typename InverterModel<T>::Parameters parameters{.dead_time_ns = dead_ns, .threshold_voltage = T(1)};
  InverterModel<T> model{parameters, T(leakage)};
  const ThreePhase<T> i{T(20), T(-8), T(-12)};
  (void)model.step({switch_states[0], period_ns}, i, T(u_dc));
  auto legs = model.legs();
  const SpaceVector<T> i_s = clarke(i);
  const SpaceVector<T> predicted = clarke(model.predicted(modulated(), i_s, i_s, T(u_dc), legs));
  const SpaceVector<T> measured = clarke(model.step(modulated(), i, T(u_dc)));
  EXPECT_NEAR(double(predicted.alpha), double(measured.alpha), 1e-3 * lost);
  EXPECT_NEAR(double(predicted.beta), double(measured.beta), 1e-3 * lost);
  EXPECT_EQ(legs.commanded, model.legs().commanded);
  EXPECT_EQ(legs.dead_ns, model.legs().dead_ns);
}

TYPED_TEST(InverterModelOf, WhileALegIsOffNothingIsKnown) {
  using T = TypeParam;
  InverterModel<T> model{{.dead_time_ns = dead_ns}, T(leakage)};
  EXPECT_EQ(model.step({gates_off, period_ns}, {T(5), T(-5), T(0)}, T(u_dc)), ThreePhase<T>{});
  EXPECT_EQ(model.step({}, {}, T(u_dc)), ThreePhase<T>{});
  GatePattern ends{switch_states[1], 10'000};
  ends.append({gates_off, 15'000});
  EXPECT_EQ(model.step(ends, {T(5), T(-5), T(0)}, T(u_dc)), ThreePhase<T>{});
  EXPECT_EQ(model.legs().commanded, gates_off);
}

TYPED_TEST(InverterModelOf, WhatIsUsable) {
  using T = TypeParam;
  const auto problem = [](const typename InverterModel<T>::Parameters& p) { return p.validate(period_ns); };
  EXPECT_EQ(problem({}), nullptr);
  EXPECT_EQ(problem({.dead_time_ns = period_ns / 2 - 1, .threshold_voltage = T(2), .slope_resistance = T(1)}),
            nullptr);
  EXPECT_STREQ(problem({.dead_time_ns = period_ns / 2}),
               "the inverter's dead time must be from zero to below half of the control period");
  EXPECT_NE(problem({.dead_time_ns = -1}), nullptr);
  EXPECT_EQ(problem({.dead_time_ns = dead_ns, .minimum_pulse = {dead_ns}}), nullptr);
  EXPECT_EQ(problem({.minimum_pulse = {period_ns / 4 - 1}}), nullptr);
  for (const std::int32_t wrong_ns : {-1, period_ns / 4, 2'000'000'000})
    EXPECT_STREQ(problem({.minimum_pulse = {wrong_ns}}),
                 "the inverter's minimum pulse must be from zero to below a quarter of the control period");
  EXPECT_NE(problem({.dead_time_ns = dead_ns, .minimum_pulse = {dead_ns - 1}}), nullptr);
  EXPECT_STREQ(problem({.threshold_voltage = T(-1)}),
               "the inverter's threshold voltage must not be below zero");
  EXPECT_STREQ(problem({.slope_resistance = std::numeric_limits<T>::quiet_NaN()}),
               "the inverter's slope resistance must not be below zero");
}

}  // namespace
}  // namespace sextant
