#include "sextant/control/flux_crossover.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(FluxCrossover, IsTheResistiveCornerWhereTheVoltageIsKnown) {
  const InductionMachineParameters<double> m;
  EXPECT_EQ(flux_crossover(m, 0.0, 1.1), m.r_s / m.l_s());
}

// 4 V move a flux of 1.1 Wb by the current model's share, √(0.25² + 0.15²), at 12.5 rad/s.
TEST(FluxCrossover, IsWhereTheVoltageErrorMovesTheFluxByWhatTheCurrentModelMayBeWrongBy) {
  InductionMachineParameters<double> m;
  m.r_s = 1e-9;
  const double omega = flux_crossover(m, 4.0, 1.1);
  EXPECT_NEAR(4.0 / omega / 1.1, std::sqrt(0.25 * 0.25 + 0.15 * 0.15), 1e-9);
  EXPECT_NEAR(flux_crossover(m, 8.0, 1.1), 2 * omega, 1e-6);
}

}  // namespace
}  // namespace sextant
