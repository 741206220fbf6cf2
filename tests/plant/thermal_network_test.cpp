// The thermal network against closed forms, the exponential of its matrix and the balance of its heat.
#include "sextant/plant/thermal_network.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Nodes = ThermalNodes<double>;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Each node by itself.
ThermalParameters<> separate() {
  ThermalParameters<> p;
  p.capacity = {500, 800, 3000};
  p.to_ambient = {5, 2, 12};
  p.ambient = 30;
  return p;
}

/// All heat leaves by the housing.
ThermalParameters<> housed() {
  ThermalParameters<> p;
  p.capacity = {500, 800, 3000};
  p.winding_to_housing = 10;
  p.rotor_to_housing = 4;
  p.to_ambient = {0, 0, 5};
  p.ambient = 40;
  return p;
}

TEST(ThermalNetwork, ANodeByItselfFollowsTheExponential) {
  const ThermalParameters<> p = separate();
  ASSERT_EQ(p.validate(), nullptr);
  ThermalNetwork<> network{p};
  const Nodes power{400, 100, 300};
  double t = 0;
  for (const double h : {0.01, 3.0, 0.25, 40.0, 1000.0, 1e-6, 7.0}) {
    network.step({power.winding * h, power.rotor * h, power.housing * h}, h);
    t += h;
    const Nodes found = network.temperatures();
    EXPECT_NEAR(found.winding, 30 + 400.0 / 5 * -std::expm1(-t * 5 / 500), 1e-10) << t;
    EXPECT_NEAR(found.rotor, 30 + 100.0 / 2 * -std::expm1(-t * 2 / 800), 1e-10) << t;
    EXPECT_NEAR(found.housing, 30 + 300.0 / 12 * -std::expm1(-t * 12 / 3000), 1e-10) << t;
  }
}

TEST(ThermalNetwork, BeginsWhereItIsTold) {
  ThermalParameters<> p = housed();
  EXPECT_NEAR(ThermalNetwork<>{p}.temperatures().winding, 40, 1e-12);
  p.start = {120, {}, 60};
  const Nodes t = ThermalNetwork<>{p}.temperatures();
  EXPECT_NEAR(t.winding, 120, 1e-12);
  EXPECT_NEAR(t.rotor, 40, 1e-12);
  EXPECT_NEAR(t.housing, 60, 1e-12);
}

// By hand: 600 W through 5 W/K, then 300 W through 10 W/K and 200 W through 4 W/K.
TEST(ThermalNetwork, SettlesWhereTheHeatFlowsOff) {
  ThermalNetwork<> network{housed()};
  for (int n = 0; n < 4000; ++n) network.step({300 * 10.0, 200 * 10.0, 100 * 10.0}, 10);
  const Nodes t = network.temperatures();
  EXPECT_NEAR(t.housing, 40 + 120, 1e-9);
  EXPECT_NEAR(t.winding, 40 + 120 + 30, 1e-9);
  EXPECT_NEAR(t.rotor, 40 + 120 + 50, 1e-9);
}

TEST(ThermalNetwork, IsOfSinglePrecisionToo) {
  ThermalParameters<float> p;
  p.capacity = {500, 800, 3000};
  p.to_ambient = {5, 2, 12};
  ASSERT_EQ(p.validate(), nullptr);
  ThermalNetwork<float> network{p};
  for (int n = 0; n < 100; ++n) network.step({400, 100, 300}, 1);
  EXPECT_NEAR(network.temperatures().winding, 20 + 80 * -std::expm1(-1.0), 1e-3);
}

/// Conductances of a random network, from weak to strong, some of them none; any node may be the one that
/// reaches the ambient.
ThermalParameters<> random_network(std::mt19937& random) {
  const auto between = [&random](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution{0.0, 1.0}(random));
  };
  const auto maybe = [&random, &between] { return random() % 3 == 0 ? 0.0 : between(0.1, 50); };
  ThermalParameters<> p;
  do {
    p = {};
    p.capacity = {between(20, 2e4), between(20, 2e4), between(20, 2e5)};
    p.winding_to_rotor = maybe();
    p.winding_to_housing = maybe();
    p.rotor_to_housing = maybe();
    p.to_ambient = {maybe(), maybe(), maybe()};
    p.ambient = std::uniform_real_distribution{-40.0, 60.0}(random);
    p.start = {between(10, 200), between(10, 200), between(10, 200)};
  } while (p.validate() != nullptr);
  return p;
}

double sum(const Nodes& x) {
  return x.winding + x.rotor + x.housing;
}

/// x' = A x of deviations from the ambient and, as states that stand still, powers; the last one is the heat
/// that has left, by all heat capacities. Nothing of it is shared with the network but the parameters.
using Whole = Eigen::Matrix<double, 7, 7>;
Whole whole_matrix(const ThermalParameters<>& p) {
  const Eigen::Vector3d c{p.capacity.winding, p.capacity.rotor, p.capacity.housing};
  const Eigen::Vector3d out{p.to_ambient.winding, p.to_ambient.rotor, p.to_ambient.housing};
  Eigen::Matrix3d between = Eigen::Matrix3d::Zero();
  between(0, 1) = between(1, 0) = p.winding_to_rotor;
  between(0, 2) = between(2, 0) = p.winding_to_housing;
  between(1, 2) = between(2, 1) = p.rotor_to_housing;
  Whole a = Whole::Zero();
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      if (j == k) continue;
      a(k, j) += between(k, j) / c[k];
      a(k, k) -= between(k, j) / c[k];
    }
    a(k, k) -= out[k] / c[k];
    a(k, 3 + k) = 1 / c[k];
    a(6, k) = out[k] / sum(p.capacity);
  }
  return a;
}

TEST(ThermalNetwork, FiftyRandomOnesMoveAsTheirMatrixAndConserveHeat) {
  constexpr unsigned seed = 20261126;
  std::mt19937 random{seed};
  for (int n = 0; n < 50; ++n) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", network " << n);
    const ThermalParameters<> p = random_network(random);
    ThermalNetwork<> network{p};
    const Whole a = whole_matrix(p);
    Eigen::Matrix<double, 7, 1> x;
    x << *p.start.winding - p.ambient, *p.start.rotor - p.ambient, *p.start.housing - p.ambient, 0, 0, 0, 0;
    const auto stored = [&p](double w, double r, double h) {
      return p.capacity.winding * w + p.capacity.rotor * r + p.capacity.housing * h;
    };
    const double begin = stored(x[0], x[1], x[2]);
    double given = 0, moved = std::abs(begin);
    for (int step = 0; step < 30; ++step) {
      const double h = 0.3 * p.shortest_time_constant() * std::uniform_real_distribution{0.01, 1.0}(random);
      for (int k = 3; k < 6; ++k) x[k] = std::uniform_real_distribution{0.0, 1e3}(random);
      given += h * (x[3] + x[4] + x[5]);
      moved += h * (x[3] + x[4] + x[5]);
      network.step({h * x[3], h * x[4], h * x[5]}, h);
      x = ((h * a).exp() * x).eval();
      const Nodes t = network.temperatures();
      const double scale = 1e-11 * (1 + x.head<3>().cwiseAbs().maxCoeff());
      EXPECT_NEAR(t.winding - p.ambient, x[0], scale + 1e-11);
      EXPECT_NEAR(t.rotor - p.ambient, x[1], scale + 1e-11);
      EXPECT_NEAR(t.housing - p.ambient, x[2], scale + 1e-11);
    }
    const Nodes t = network.temperatures();
    const double end = stored(t.winding - p.ambient, t.rotor - p.ambient, t.housing - p.ambient);
    EXPECT_NEAR(end - begin, given - sum(p.capacity) * x[6], 1e-10 * moved)
        << "what is given is stored or has left";
  }
}

TEST(ThermalParameters, WhatMakesNoNetworkIsRefused) {
  EXPECT_EQ(ThermalParameters<>{}.validate(), nullptr);
  EXPECT_FALSE(ThermalParameters<>{}.acts());
  EXPECT_EQ(housed().validate(), nullptr);
  const auto refusal = [](auto change) {
    ThermalParameters<> p = housed();
    change(p);
    const char* const reason = p.validate();
    return std::string{reason == nullptr ? "accepted" : reason};
  };
  EXPECT_THAT(refusal([](auto& p) { p.capacity.rotor = 0; }),
              HasSubstr("must each have a heat capacity above zero"));
  EXPECT_THAT(refusal([](auto& p) { p.capacity = {}; }), HasSubstr("need heat capacities above zero"));
  EXPECT_THAT(refusal([](auto& p) { p.capacity.winding = -1; }), HasSubstr("finite and not below zero"));
  EXPECT_THAT(refusal([](auto& p) { p.winding_to_rotor = nan; }), HasSubstr("finite and not below zero"));
  EXPECT_THAT(refusal([](auto& p) { p.winding_coefficient = -1e-3; }),
              HasSubstr("finite and not below zero"));
  EXPECT_THAT(refusal([](auto& p) { p.ambient = nan; }), HasSubstr("temperatures of the thermal network"));
  EXPECT_THAT(refusal([](auto& p) { p.start.rotor = nan; }),
              HasSubstr("temperatures of the thermal network"));
  EXPECT_THAT(refusal([](auto& p) { p.step_ns = 0; }), HasSubstr("must be above zero"));
  EXPECT_THAT(refusal([](auto& p) { p.to_ambient.housing = 0; }), HasSubstr("on a way to the ambient"));
  EXPECT_THAT(refusal([](auto& p) { p.rotor_to_housing = 0; }), HasSubstr("on a way to the ambient"));
  EXPECT_THAT(refusal([](auto& p) { p.step_ns = 2'000'000'000, p.capacity.winding = 199; }),
              HasSubstr("at most a tenth of its shortest time constant"));
  EXPECT_EQ(refusal([](auto& p) { p.step_ns = 2'000'000'000, p.capacity.winding = 201; }), "accepted");
  EXPECT_THAT(refusal([](auto& p) { p.start.winding = -240; }),
              HasSubstr("must be above zero at the lowest of ambient and first temperatures"));
  EXPECT_EQ(refusal([](auto& p) { p.start.winding = -220; }), "accepted");
}

}  // namespace
}  // namespace sextant
