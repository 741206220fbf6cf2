// R_s of the flux estimator by the temperature of the winding, against the ratio of IEC 60034-1 for copper,
// (235 + ϑ_2)/(235 + ϑ_1), alone and with an R_s that has been identified.
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "control/controlled_machine.hpp"

namespace sextant {
namespace {

constexpr double cold = 20;

constexpr double copper_ratio(double from, double to) {
  return (235 + to) / (235 + from);
}

template <class T>
class WarmResistanceOf : public testing::Test {
 protected:
  using Estimator = FluxTorqueEstimator<T>;

  static typename Estimator::Parameters parameters(bool adapts) {
    return {.machine = test::converted<T>({}),
            .kind = FluxEstimatorKind::hybrid,
            .adapts = adapts,
            .winding = {T(1 / (235 + cold)), T(cold)}};
  }

  static void expect_r_s(const Estimator& estimator, double expected) {
    EXPECT_NEAR(double(estimator.machine().r_s), expected, 1e-5 * expected);
  }

  /// What the estimator knows after a second of magnetising at 15 rad/s a machine with this R_s, at this
  /// temperature, and so many periods at 20 N·m.
  static Estimator identified(const typename Estimator::Parameters& p, double r_s, std::optional<T> celsius,
                              int periods_with_torque = 1) {
    InductionMachineParameters<double> real;
    real.r_s = r_s;
    typename DirectTorqueController<T>::Parameters known;
    known.machine = test::converted<T>(real);
    known.magnetiser = {.current_limit = T(23), .hand_over_current = T(16)};
    test::ControlledMachine<T> loop{known, real};
    loop.machine.omega_m = 15;
    Estimator estimator{p};
    const auto see = [&](bool magnetising) {
      Measurement<T> m = loop.machine.template measure<T>(loop.applied());
      m.winding_temperature = celsius;
      estimator.step(m, magnetising);
    };
    see(false);
    for (int k = 0; k < 4000; ++k) {
      loop.step(ControlMode::magnetise, 0);
      see(true);
    }
    for (int k = 0; k < periods_with_torque; ++k) {
      loop.step(ControlMode::torque, T(20));
      see(false);
    }
    return estimator;
  }

  static Measurement<T> at(std::optional<T> celsius) {
    Measurement<T> m;
    m.u_dc = T(530);
    m.applied = {gates_off, 25'000};
    m.winding_temperature = celsius;
    return m;
  }

  static constexpr double nominal = 0.435;  // of the paper's machine [Ω]
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(WarmResistanceOf, Scalars);

TYPED_TEST(WarmResistanceOf, FollowsTheTemperatureWithAndWithoutAdaptation) {
  using T = TypeParam;
  for (const bool adapts : {false, true}) {
    FluxTorqueEstimator<T> estimator{this->parameters(adapts)};
    estimator.step(this->at({}));
    EXPECT_EQ(estimator.machine().r_s, T(this->nominal)) << "not known";
    for (const double hot : {80.0, 20.0, 120.0, -10.0, 155.0}) {
      estimator.step(this->at(T(hot)));
      this->expect_r_s(estimator, this->nominal * copper_ratio(cold, hot));
    }
    estimator.step(this->at({}));
    this->expect_r_s(estimator, this->nominal * copper_ratio(cold, 155));
    EXPECT_EQ(estimator.machine().r_r, T(0.816));
  }
}

TYPED_TEST(WarmResistanceOf, StaysAsConfiguredWithoutACoefficient) {
  using T = TypeParam;
  auto parameters = this->parameters(true);
  parameters.winding = {};
  FluxTorqueEstimator<T> estimator{parameters};
  estimator.step(this->at(T(150)));
  EXPECT_EQ(estimator.machine().r_s, T(this->nominal));
}

TYPED_TEST(WarmResistanceOf, AResetReturnsToWhatIsConfiguredAtTheTemperature) {
  using T = TypeParam;
  FluxTorqueEstimator<T> estimator = this->identified(this->parameters(true), 1.3 * this->nominal, T(cold));
  estimator.reset();
  estimator.step(this->at(T(90)));
  this->expect_r_s(estimator, this->nominal * copper_ratio(cold, 90));
}

// The rule: temperature scales, and what is found is kept as a factor.
TYPED_TEST(WarmResistanceOf, WhatHasBeenIdentifiedIsScaled) {
  using T = TypeParam;
  FluxTorqueEstimator<T> estimator = this->identified(this->parameters(true), 1.3 * this->nominal, T(cold));
  const double found = double(estimator.machine().r_s);
  EXPECT_NEAR(found, 1.3 * this->nominal, 0.03 * 1.3 * this->nominal);
  estimator.step(this->at(T(110)));
  this->expect_r_s(estimator, found * copper_ratio(cold, 110));
  estimator.step(this->at(T(60)));
  this->expect_r_s(estimator, found * copper_ratio(cold, 60));
}

// Three times R_s at 20 °C is beyond what identification allows, 2.5; of a winding that is known to be at
// 150 °C it is twice the R_s there.
TYPED_TEST(WarmResistanceOf, BoundsOfTheIdentificationAreThoseOfTheWarmWinding) {
  using T = TypeParam;
  const double warm = this->nominal * copper_ratio(cold, 150);
  const double real = 3 * this->nominal;
  const auto known = this->identified(this->parameters(true), real, T(150));
  EXPECT_NEAR(double(known.machine().r_s), real, 0.03 * real);
  const auto unknown = this->identified(this->parameters(true), real, {});
  EXPECT_EQ(unknown.machine().r_s, T(this->nominal)) << "nothing is taken over";
  EXPECT_GT(real, 1.9 * warm);
}

TYPED_TEST(WarmResistanceOf, BoundsOfTheAdaptationAreThoseOfTheWarmWinding) {
  using T = TypeParam;
  const double real = 3 * this->nominal;
  const auto known = this->identified(this->parameters(true), real, T(150), 2000);
  EXPECT_NEAR(double(known.machine().r_s), real, 0.03 * real);
}

}  // namespace
}  // namespace sextant
