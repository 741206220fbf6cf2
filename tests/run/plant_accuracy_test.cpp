// What the integrators of bounded time are worth over one second of a drive's own switching.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "support/recorded_switching.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

/// Torque at the end of each period. [N·m]
std::vector<double> torques(PlantIntegrator<Plant>& integrator, const std::vector<SwitchState>& sequence) {
  Plant plant{DrivePlantParameters<double>{}};
  std::vector<double> tau_e;
  for (const SwitchState state : sequence) {
    plant.set_inputs({state, 530.0, 2.0, false, 0.0});
    EXPECT_TRUE(integrator.advance(plant, testing::recorded_period_ns));
    tau_e.push_back(plant.tau_e());
  }
  return tau_e;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) largest = std::max(largest, std::abs(a[n] - b[n]));
  return largest;
}

CvodeParameters cvode_at(double tolerance) {
  CvodeParameters p{};
  p.relative_tolerance = tolerance;
  p.flux_tolerance = p.speed_tolerance = p.angle_tolerance = 1e-2 * tolerance;
  return p;
}

TEST(PlantAccuracy, OneStepForEachConstantVoltageIsWithinAMillionthOfANewtonMetre) {
  const std::vector<SwitchState> sequence = testing::record_switching(1.0);
  ASSERT_EQ(sequence.size(), 40'000U);
  CvodeIntegrator<Plant> cvode{cvode_at(1e-10)};
  CvodeIntegrator<Plant> tighter{cvode_at(1e-12)};
  FixedStepIntegrator<Plant> fixed;
  ExactIntegrator<Plant> exact;
  ErkIntegrator<Plant> erk;
  const std::vector<double> reference = torques(tighter, sequence);
  ASSERT_GT(*std::max_element(reference.begin(), reference.end()), 20.0);
  const double by_fixed = largest_difference(torques(fixed, sequence), reference);
  const double by_exact = largest_difference(torques(exact, sequence), reference);
  const double by_erk = largest_difference(torques(erk, sequence), reference);
  EXPECT_LT(by_fixed, 1e-6);
  EXPECT_LT(by_exact, 1e-6);
  EXPECT_LT(by_erk, 1e-6);
  // At 1e-10 CVODE's local errors, new at each of some 30 000 restarts, add up to more than that of any of
  // these.
  const std::vector<double> at_1e_10 = torques(cvode, sequence);
  const double of_reference = largest_difference(at_1e_10, reference);
  EXPECT_GT(of_reference, by_fixed);
  EXPECT_LT(largest_difference(torques(fixed, sequence), at_1e_10), 1e-5);
  std::printf("torque against CVODE at 1e-12 [N·m]: fixed %.1e, exact %.1e, erk %.1e, CVODE at 1e-10 %.1e\n",
              by_fixed, by_exact, by_erk, of_reference);
}

}  // namespace
}  // namespace sextant
