// The example of docs/own_controller.md, closed around the reference machine.
#include <complex>

#include <gtest/gtest.h>

#include "../../examples/controller/field_oriented_controller.hpp"
#include "control/controlled_machine.hpp"

namespace sextant {
namespace {

using Example = example::FieldOrientedController<>;

// ψ_r = L_m/L_s ψ_ref at each share of the flux reference, and the torque that is asked for at each.
TEST(ExampleController, TheMachineHasTheShareOfTheFluxAndTheTorque) {
  Example::Parameters p;
  p.period_ns = test::ControlledMachine<double, Example>::period_ns;
  test::ControlledMachine<double, Example> loop{p};
  loop.machine.omega_m = 50;
  ASSERT_GT(loop.magnetise(), 0);
  for (const double share : {1.0, 0.4, 0.7}) {
    loop.flux_share = share;
    EXPECT_NEAR(loop.run(ControlMode::torque, 8, 500), 8, 0.1) << share;
    const double psi_r = share * p.flux_reference * p.machine.l_m / p.machine.l_s();
    EXPECT_NEAR(std::abs(loop.machine.psi_r), psi_r, 0.01 * psi_r) << share;
  }
}

}  // namespace
}  // namespace sextant
