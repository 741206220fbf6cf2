#include "sextant/control/normal_equations.hpp"

#include <cmath>
#include <cstddef>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::size_t n = 5;
using Equations = NormalEquations<double, n>;

/// Of fifty random observations of n unknowns.
Equations drawn(unsigned seed) {
  std::mt19937 generator{seed};
  std::normal_distribution<double> normal;
  Equations out;
  for (int row = 0; row < 50; ++row) {
    Equations::Row coefficients{};
    for (double& c : coefficients) c = normal(generator);
    out.add(coefficients, normal(generator), 1.0 + std::abs(normal(generator)));
  }
  return out;
}

Eigen::MatrixXd matrix_of(const Equations& e) {
  Eigen::MatrixXd m(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) m(Eigen::Index(i), Eigen::Index(k)) = e.left[i][k];
  }
  return m;
}

TEST(NormalEquations, HaveTheSolutionAndTheInverseOfAReference) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Equations e = drawn(seed);
    const auto found = e.solve();
    ASSERT_TRUE(found.exists);
    const Eigen::MatrixXd inverse = matrix_of(e).inverse();
    const Equations::Matrix own = found.inverse();
    const Eigen::VectorXd x = inverse * Eigen::Map<const Eigen::VectorXd>(e.right.data(), n);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(found.x[i], x(Eigen::Index(i)), 1e-9);
      for (std::size_t k = 0; k < n; ++k) {
        EXPECT_NEAR(own[i][k], inverse(Eigen::Index(i), Eigen::Index(k)), 1e-9);
      }
    }
  }
}

TEST(NormalEquations, LeaveAFixedUnknownOut) {
  Equations e = drawn(3);
  Eigen::MatrixXd m = matrix_of(e).topLeftCorner(4, 4);
  const Eigen::VectorXd x = m.inverse() * Eigen::Map<const Eigen::VectorXd>(e.right.data(), 4);
  e.fix(4);
  const auto found = e.solve();
  EXPECT_EQ(found.x[4], 0.0);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(found.x[i], x(Eigen::Index(i)), 1e-9);
}

// The least sum of squares with x_1 ≥ 0: that of all unknowns where its x_1 is not below zero, else that
// without it.
TEST(NormalEquations, KeepAnUnknownFromBelowZero) {
  int below = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Equations e = drawn(seed);
    const auto free = e.solve();
    const auto found = e.solve_with_positive(1);
    Equations without = e;
    without.fix(1);
    below += free.x[1] < 0 ? 1 : 0;
    EXPECT_EQ(found.x, free.x[1] < 0 ? without.solve().x : free.x);
  }
  EXPECT_GT(below, 3);
  EXPECT_LT(below, 17);
}

TEST(NormalEquations, HaveNoSolutionWhereAnUnknownIsNotSeen) {
  Equations e;
  e.add({1, 1, 0, 0, 0}, 1, 1);
  const auto found = e.solve();
  EXPECT_FALSE(found.exists);
  EXPECT_EQ(found.x, Equations::Row{});
  EXPECT_EQ(found.inverse(), Equations::Matrix{});
}

}  // namespace
}  // namespace sextant
