#include "sextant/power_stage/simulated_power_stage.hpp"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"

namespace sextant {
namespace {

using Parameters = SimulatedPowerStage::Parameters;

TEST(SimulatedPowerStage, ChecksEveryPartOfItself) {
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  Parameters p;
  p.plant.viscous_friction = -1.0;
  EXPECT_STREQ(p.validate(), p.plant.validate());
  p = {};
  p.io.u_dc = std::numeric_limits<double>::quiet_NaN();
  EXPECT_STREQ(p.validate(), p.io.validate());
  p = {};
  p.cvode.relative_tolerance = 0.0;
  EXPECT_STREQ(p.validate(), p.cvode.validate());
}

TEST(SimulatedPowerStage, RefusesAMalformedLoad) {
  MechanicalLoad::Parameters load;
  load.load_torque = {.shape = ProfileShape::steps, .points = {}};
  EXPECT_THROW((SimulatedPowerStage{Parameters{}, load}), std::runtime_error);
}

// Open loop: all integrators follow the same patterns, so that their states can be compared.
TEST(SimulatedPowerStage, AllIntegratorsMoveTheSamePlant) {
  MechanicalLoad::Parameters load;
  load.load_torque = {.shape = ProfileShape::steps, .points = {{0.0, 1.0}, {0.00301, 4.0}}};
  Parameters p;
  p.integrator = IntegratorKind::fixed;
  SimulatedPowerStage fixed{p, load};
  p.integrator = IntegratorKind::cvode;
  p.cvode.relative_tolerance = p.cvode.flux_tolerance = p.cvode.speed_tolerance = 1e-9;
  SimulatedPowerStage cvode{p, load};
  p.integrator = IntegratorKind::exact;
  SimulatedPowerStage exact{p, load};
  p.integrator = IntegratorKind::erk;
  SimulatedPowerStage erk{p, load};
  for (std::int64_t k = 0; k <= 400; ++k) {
    const GatePattern pattern = k % 100 < 90 ? GatePattern{switch_states[std::size_t(1 + k / 100)], 25'000}
                                             : GatePattern{gates_off, 25'000};
    for (SimulatedPowerStage* stage : {&fixed, &cvode, &exact, &erk}) {
      ASSERT_TRUE(stage->io().read(k * 25'000).plausible);
      stage->io().write(k % 3 == 0 ? pattern : GatePattern{switch_states[0], 25'000});
    }
  }
  EXPECT_GT(magnitude(fixed.io().plant().psi_s()), 0.1);
  for (SimulatedPowerStage* other : {&cvode, &exact, &erk}) {
    EXPECT_LT(magnitude(fixed.io().plant().psi_s() - other->io().plant().psi_s()), 1e-7);
    EXPECT_NEAR(fixed.io().plant().omega_m(), other->io().plant().omega_m(), 1e-6);
  }
}

}  // namespace
}  // namespace sextant
