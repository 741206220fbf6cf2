#include "sextant/event_exact/continuous_comparators.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sextant/control/switching_table.hpp"

namespace sextant {
namespace {

constexpr double mask_wb = 1e-3;
constexpr double degree = std::numbers::pi / 180;

ContinuousComparators::Inputs inputs(double flux, double angle_deg, double torque, double reference) {
  return {polar(flux, angle_deg * degree), torque, reference};
}

TEST(ContinuousComparators, DecideAsTheSampledOnesDo) {
  constexpr unsigned seed = 20221105;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> flux{1.05, 1.15}, angle{-180, 180}, torque{-3, 3};
  const DirectTorqueController<>::Parameters p{{.flux_reference = 1.1}};
  ContinuousComparators continuous{p, mask_wb};
  TorqueComparator<> torque_comparator{p.torque_comparator};
  FluxComparator<> flux_comparator{p.flux_comparator};
  SectorSelector<> sector{p.sector};
  SwitchState state = switch_states[0];
  for (int n = 0; n < 2000; ++n) {
    const auto in = inputs(flux(random), angle(random), torque(random), 0.5);
    continuous.settle(in, -1);
    state = select_state(sector.step(in.psi_s), flux_comparator.step(1.1 - magnitude(in.psi_s)),
                         torque_comparator.step(in.torque_reference - in.torque), state);
    ASSERT_EQ(continuous.state(), state) << "sample " << n;
    ASSERT_EQ(continuous.sector(), sector.sector()) << "sample " << n;
  }
}

TEST(ContinuousComparators, NothingIsLeftToCrossOnceSettled) {
  constexpr unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> flux{0, 1.3}, angle{-180, 180}, torque{-30, 30};
  ContinuousComparators comparators{{}, mask_wb};
  for (int n = 0; n < 2000; ++n) {
    const auto in = inputs(flux(random), angle(random), torque(random), torque(random));
    comparators.settle(in, -1);
    for (const double g : comparators.events(in)) ASSERT_GE(g, 0) << "sample " << n;
  }
}

TEST(ContinuousComparators, TheEventFunctionsVanishOnTheThresholds) {
  ContinuousComparators c{{{.flux_reference = 1.1}}, mask_wb};
  c.settle(inputs(1.1, 10, 0, 0), -1);
  const double band = TorqueComparator<>::Parameters{}.upper_band;
  const double flux_band = FluxComparator<>::Parameters{}.band;
  EXPECT_NEAR(c.event(ContinuousComparators::torque_above, inputs(1.1, 10, 5 - band, 5)), 0, 1e-14);
  EXPECT_NEAR(c.event(ContinuousComparators::torque_below, inputs(1.1, 10, 5 + band, 5)), 0, 1e-14);
  EXPECT_NEAR(c.event(ContinuousComparators::flux, inputs(1.1 + flux_band, 10, 0, 0)), 0, 1e-14);
  EXPECT_NEAR(c.event(ContinuousComparators::sector_upper, inputs(1.1, 30, 0, 0)), 0, 1e-14);
  EXPECT_NEAR(c.event(ContinuousComparators::sector_lower, inputs(1.1, -30, 0, 0)), 0, 1e-14);
}

TEST(ContinuousComparators, ARelayThatIsOnWaitsForZeroErrorAndHasOnlyThatEvent) {
  ContinuousComparators c{{}, mask_wb};
  c.settle(inputs(1.1, 0, 0, 5), -1);
  ASSERT_EQ(c.torque_demand(), 1);
  EXPECT_NEAR(c.event(ContinuousComparators::torque_below, inputs(1.1, 0, 4.5, 5)), 0.5, 1e-14);
  EXPECT_EQ(c.event(ContinuousComparators::torque_above, inputs(1.1, 0, -100, 5)), 1);
  c.settle(inputs(1.1, 0, 5, 5), ContinuousComparators::torque_below);
  EXPECT_EQ(c.torque_demand(), 0) << "the event counts though the error is exactly zero";
}

TEST(ContinuousComparators, TheSectorStandsWhileThereIsNoFlux) {
  ContinuousComparators c{{}, mask_wb};
  c.settle(inputs(0, 0, 0, 0), -1);
  EXPECT_EQ(c.sector(), 1);
  c.settle(inputs(0.9 * mask_wb, 170, 0, 0), -1);
  EXPECT_EQ(c.sector(), 1) << "below the mask";
  c.settle(inputs(1.1 * mask_wb, 170, 0, 0), -1);
  EXPECT_EQ(c.sector(), 4);
  c.settle(inputs(0.6 * mask_wb, -100, 0, 0), -1);
  EXPECT_EQ(c.sector(), 5) << "masked again only at half of it";
  c.settle(inputs(0.4 * mask_wb, -100, 0, 0), -1);
  c.settle(inputs(0.4 * mask_wb, 60, 0, 0), -1);
  EXPECT_EQ(c.sector(), 5);
}

TEST(ContinuousComparators, CountThePulsesOfTheTorqueComparator) {
  ContinuousComparators c{{}, mask_wb};
  for (int n = 0; n < 5; ++n) {
    c.settle(inputs(1.1, 0, 0, 2), -1);
    c.settle(inputs(1.1, 0, 2.1, 2), -1);
  }
  EXPECT_EQ(c.torque_pulses(), 5);
}

}  // namespace
}  // namespace sextant
