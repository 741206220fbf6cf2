// Currents that are sampled one after another.
#include <array>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/power_stage/simulated_drive_io.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

constexpr std::int32_t period_ns = 25'000;

/// Phase currents that are read at the end of a number of periods of one vector, from a dead machine at rest.
ThreePhase<> read_after(int periods, std::int32_t lead_ns, std::int32_t skew_ns) {
  SimulatedDriveIoParameters p;
  p.sensors.sampling_lead_ns = lead_ns;
  p.sensors.sampling_skew_ns = skew_ns;
  EXPECT_EQ(p.validate(), nullptr);
  const MechanicalLoad load{{.imposed_speed = ProfileParameters{}}};
  Plant plant{DrivePlantParameters<double>{}};
  FixedStepIntegrator<Plant> integrator;
  SimulatedDriveIo<Plant> io{p, plant, integrator, load};
  Measurement<double> m = io.read(0);
  for (int n = 1; n <= periods; ++n) {
    io.write({switch_states[1], period_ns});
    m = io.read(std::int64_t{n} * period_ns);
  }
  return m.i_abc;
}

// From zero the current rises by u/σL_s: i_a = 2/3 u_dc t/σL_s, i_b = i_c = −i_a/2, each at its own instant.
// Resistances take 1 % within a period.
TEST(SamplingSkew, EachPhaseIsReadAtItsOwnInstant) {
  const double slope = 2.0 / 3.0 * 530 / InductionMachineParameters<>{}.sigma_l_s();
  const ThreePhase<> i = read_after(1, 2'000, 5'000);
  EXPECT_NEAR(i.a, slope * 13e-6, 0.01 * slope * 13e-6);
  EXPECT_NEAR(i.b, -slope / 2 * 18e-6, 0.01 * slope * 18e-6);
  EXPECT_NEAR(i.c, -slope / 2 * 23e-6, 0.01 * slope * 23e-6);
}

// The same instants, taken one by one by the lead.
TEST(SamplingSkew, IsALeadOfItsOwnOfEachPhase) {
  const ThreePhase<> i = read_after(7, 1'000, 6'000);
  EXPECT_NEAR(i.a, read_after(7, 13'000, 0).a, 1e-6);
  EXPECT_NEAR(i.b, read_after(7, 7'000, 0).b, 1e-6);
  EXPECT_NEAR(i.c, read_after(7, 1'000, 0).c, 1e-6);
  const ThreePhase<> none = read_after(7, 0, 0);
  EXPECT_GT(std::abs(none.a - i.a), 0.5);
  EXPECT_NEAR(read_after(7, 0, 6'000).c, none.c, 1e-6);
}

TEST(SamplingSkew, MustFitIntoThePeriod) {
  SimulatedDriveIoParameters p;
  p.sensors.sampling_skew_ns = 12'500;
  EXPECT_EQ(p.validate(), nullptr);
  p.sensors.sampling_lead_ns = 1'000;
  EXPECT_NE(p.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
