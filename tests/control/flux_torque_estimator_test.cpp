#include "sextant/control/flux_torque_estimator.hpp"

#include <cfenv>
#include <cmath>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"
#include "sextant/control/electromagnetic_torque.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;

template <class T>
class FluxTorqueEstimatorOf : public testing::Test {
 protected:
  void drive(int periods) {
    for (int k = 0; k < periods; ++k) {
      // Six-step operation with a zero vector in every other period.
      const unsigned n = k % 2 == 0 ? unsigned(k / 60 % 6) + 1U : 0U;
      const GatePattern pattern{switch_states[n], period_ns};
      machine.apply(pattern);
      estimator.step(machine.measure<T>(pattern));
    }
  }

  void coast(int periods) {
    for (int k = 0; k < periods; ++k) {
      machine.coast(period_ns);
      estimator.step(machine.measure<T>(GatePattern{gates_off, period_ns}));
    }
  }

  void expect_agreement(double flux_tolerance, double torque_tolerance) const {
    EXPECT_NEAR(double(estimator.psi_s().alpha), machine.psi_s.real(), flux_tolerance);
    EXPECT_NEAR(double(estimator.psi_s().beta), machine.psi_s.imag(), flux_tolerance);
    EXPECT_NEAR(double(estimator.torque()), machine.torque(), torque_tolerance);
  }

  test::ReferenceMachine machine{};
  FluxTorqueEstimator<T> estimator{{.machine = test::converted<T>({})}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(FluxTorqueEstimatorOf, Scalars);

TYPED_TEST(FluxTorqueEstimatorOf, TorqueIsThreeHalvesPolePairsFluxCrossCurrent) {
  using T = TypeParam;
  // 1 Wb along alpha and 10 A along beta, two pole pairs: 3/2 · 2 · 10 = 30 N·m.
  EXPECT_NEAR(electromagnetic_torque<T>(2, {T(1), T(0)}, {T(4), T(10)}), T(30), T(1e-5));
  EXPECT_NEAR(electromagnetic_torque<T>(2, {T(0), T(1)}, {T(10), T(4)}), T(-30), T(1e-5));
}

TYPED_TEST(FluxTorqueEstimatorOf, FollowsADrivenMachine) {
  this->machine.omega_m = 60;
  this->drive(2000);
  EXPECT_GT(std::abs(this->machine.psi_s), 0.1);
  this->expect_agreement(2e-4, 0.1);
}

TYPED_TEST(FluxTorqueEstimatorOf, CarriesTheFluxThroughGatesOffAndBack) {
  this->machine.omega_m = 60;
  this->drive(2000);
  const double before = std::abs(this->machine.psi_r);
  this->coast(2000);
  EXPECT_LT(std::abs(this->machine.psi_r), 0.75 * before);
  EXPECT_GT(std::abs(this->machine.psi_r), 0.3 * before);
  this->expect_agreement(5e-4, 1e-6);
  this->drive(1000);
  this->expect_agreement(1e-3, 0.3);
}

TYPED_TEST(FluxTorqueEstimatorOf, APeriodOfWhichAPartWasOffCountsAsCoasting) {
  using T = TypeParam;
  GatePattern mixed;
  mixed.append({switch_states[1], 10'000});
  mixed.append({gates_off, 15'000});
  Measurement<T> m;
  m.u_dc = T(530);
  m.applied = mixed;
  this->estimator.step(m);
  EXPECT_EQ(this->estimator.psi_s(), SpaceVector<T>{});
}

// A link without voltage puts nothing against a current, and a current of zero is no reason to divide by it.
TYPED_TEST(FluxTorqueEstimatorOf, AnOpenInverterWithoutLinkVoltageIsNoDivisionByZero) {
  using T = TypeParam;
  for (const T u_dc : {T(0), T(-0.0), T(-5), T(1e-30), T(530)}) {
    for (const T current : {T(0), T(10)}) {
      for (const std::int32_t periods : {0, 1, 200}) {
        FluxTorqueEstimator<T> fresh{{}};
        Measurement<T> m;
        m.u_dc = u_dc;
        m.applied = GatePattern{gates_off, periods * period_ns};
        m.i_abc = {current, -current / T(2), -current / T(2)};
        std::feclearexcept(FE_ALL_EXCEPT);
        fresh.step(m);
        fresh.step(m);
        EXPECT_EQ(std::fetestexcept(FE_INVALID | FE_DIVBYZERO), 0) << u_dc << " V, " << current << " A";
        EXPECT_TRUE(std::isfinite(magnitude(fresh.psi_s())));
      }
    }
  }
}

TYPED_TEST(FluxTorqueEstimatorOf, ForgetsTheFluxOnReset) {
  using T = TypeParam;
  this->drive(100);
  this->estimator.reset();
  EXPECT_EQ(this->estimator.psi_s(), SpaceVector<T>{});
  EXPECT_EQ(this->estimator.torque(), T(0));
  // Nothing of before comes back when the gates stay off without current.
  Measurement<T> m;
  m.applied = GatePattern{gates_off, period_ns};
  this->estimator.step(m);
  EXPECT_EQ(this->estimator.psi_s(), SpaceVector<T>{});
}

// A machine that is turned off keeps its rotor flux for a while.
TYPED_TEST(FluxTorqueEstimatorOf, KeepsTheRotorFluxOnRestart) {
  using T = TypeParam;
  this->drive(100);
  Measurement<T> m;
  m.applied = GatePattern{gates_off, period_ns};
  this->estimator.step(m);
  const SpaceVector<T> before = this->estimator.psi_s();
  ASSERT_GT(magnitude(before), T(0));
  this->estimator.restart();
  EXPECT_EQ(this->estimator.psi_s(), before);
  EXPECT_EQ(this->estimator.torque(), T(0));
  this->estimator.step(m);
  EXPECT_NEAR(magnitude(this->estimator.psi_s()), magnitude(before), T(1e-2) * magnitude(before));
  m.applied = GatePattern{gates_off, 2'000'000'000};
  this->estimator.step(m);
  EXPECT_LT(magnitude(this->estimator.psi_s()), T(1e-6) * magnitude(before));
}

// At small fluxes the leakage of iron that saturates is a few percent larger than at its L_m. In the first
// periods that is more than the rotor flux, whose direction is that of the current.
TYPED_TEST(FluxTorqueEstimatorOf, FirstMagnetisingCurrentHasItsRotorFluxBesideAKnownSaturation) {
  using T = TypeParam;
  FluxTorqueEstimator<T> knowing{{.machine = test::converted<T>({}),
                                  .kind = FluxEstimatorKind::hybrid,
                                  .saturation = {.knee = T(1.1), .exponent = 7, .machine_flux = T(1.1)}}};
  knowing.step(this->machine.template measure<T>(GatePattern{switch_states[0], period_ns}), true);
  for (int k = 0; k < 20; ++k) {
    const GatePattern pattern{switch_states[k % 3 == 0 ? 1U : 0U], period_ns};
    this->machine.apply(pattern);
    knowing.step(this->machine.template measure<T>(pattern), true);
    const SpaceVector<T> psi_r = knowing.current_model().psi_r_from(knowing.psi_s(), knowing.i_s());
    EXPECT_GT(dot(psi_r, knowing.i_s()), T(0)) << k;
    EXPECT_NEAR(double(psi_r.alpha), this->machine.psi_r.real(), 0.1 * this->machine.psi_r.real() + 2e-4)
        << k;
  }
}

}  // namespace
}  // namespace sextant
