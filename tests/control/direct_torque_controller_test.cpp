#include "sextant/control/direct_torque_controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "control/dtc_loop.hpp"

namespace sextant {
namespace {

using test::Loop;

/// Mean torque, its RMS deviation from the demand, and the range of the flux over the settled end of a run.
struct Settled {
  double mean{};
  double rms{};
  double flux_min{std::numeric_limits<double>::infinity()};
  double flux_max{};
};

template <class T>
Settled settle_at(Loop<T>& loop, double torque) {
  for (int k = 0; k < 8000; ++k) loop.step(ControlMode::torque, torque);
  Settled result;
  const int samples = 4000;
  for (int k = 0; k < samples; ++k) {
    loop.step(ControlMode::torque, torque);
    const double error = loop.machine.torque() - torque;
    const double flux = std::abs(loop.machine.psi_s);
    result.mean += loop.machine.torque() / samples;
    result.rms += error * error / samples;
    result.flux_min = std::min(result.flux_min, flux);
    result.flux_max = std::max(result.flux_max, flux);
  }
  result.rms = std::sqrt(result.rms);
  return result;
}

template <class T>
class DirectTorqueControllerOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DirectTorqueControllerOf, Scalars);

TYPED_TEST(DirectTorqueControllerOf, ADeadMachineGivesFifteenNewtonMetresWithinFiveMilliseconds) {
  using T = TypeParam;
  for (const double torque : {15.0, -15.0}) {
    Loop<T> loop;
    int periods = 0;
    while (periods < 200 && std::abs(loop.machine.torque()) < 0.95 * 15) {
      loop.step(ControlMode::torque, torque);
      ++periods;
    }
    EXPECT_LT(periods, 200);
    EXPECT_EQ(loop.machine.torque() > 0, torque > 0);
  }
}

TYPED_TEST(DirectTorqueControllerOf, HoldsTorqueAndFluxInAllFourQuadrantsWithAndWithoutDelay) {
  using T = TypeParam;
  for (const int delay : {0, 1}) {
    for (const double omega_m : {50.0, -50.0}) {
      for (const double torque : {15.0, -15.0}) {
        SCOPED_TRACE(testing::Message() << torque << " N·m at " << omega_m << " rad/s, delay " << delay);
        typename DirectTorqueController<T>::Parameters parameters;
        parameters.actuation_delay_periods = delay;
        Loop<T> loop{parameters, delay};
        loop.machine.omega_m = omega_m;
        const Settled settled = settle_at(loop, torque);
        EXPECT_NEAR(settled.mean, torque, 2);
        EXPECT_LT(settled.rms, 5);
        // The band and two periods of 2/3 of 530 V, 8.8 mWb each.
        EXPECT_GT(settled.flux_min, 1.1 - 0.03);
        EXPECT_LT(settled.flux_max, 1.1 + 0.03);
      }
    }
  }
}

TYPED_TEST(DirectTorqueControllerOf, KnowingTheDelayLessensTheRipple) {
  using T = TypeParam;
  typename DirectTorqueController<T>::Parameters parameters;
  Loop<T> unaware{parameters, 1};
  parameters.actuation_delay_periods = 1;
  Loop<T> aware{parameters, 1};
  unaware.machine.omega_m = 50;
  aware.machine.omega_m = 50;
  EXPECT_LT(settle_at(aware, 15).rms, 0.8 * settle_at(unaware, 15).rms);
}

// At half of flux reference and nominal link a relay switches at a quarter of its band.
TYPED_TEST(DirectTorqueControllerOf, TheTorqueBandsGoWithFluxReferenceAndLinkVoltage) {
  using T = TypeParam;
  typename DirectTorqueController<T>::Parameters parameters;
  parameters.torque_trim.time_constant = T(0);
  parameters.torque_comparator.upper_band = parameters.torque_comparator.lower_band = T(16);
  parameters.u_dc = T(2 * 530);
  Loop<T> loop{parameters};
  loop.machine.omega_m = 50;
  int between = 0;
  for (int k = 0; k < 12'000; ++k) {
    loop.step(ControlMode::torque, 10, 0.5);
    const double error = 10 - double(loop.controller().estimate().torque);
    if (k < 4000 || std::abs(error) <= 4 + 1e-4) continue;
    if (std::abs(error) < 16) ++between;
    ASSERT_EQ(loop.controller().torque_demand(), error > 0 ? 1 : -1) << error;
  }
  EXPECT_GT(between, 100);
}

TYPED_TEST(DirectTorqueControllerOf, FollowsATorqueReversalWithinMilliseconds) {
  using T = TypeParam;
  Loop<T> loop;
  loop.machine.omega_m = 50;
  settle_at(loop, 15);
  int periods = 0;
  while (periods < 100 && loop.machine.torque() > -0.95 * 15) {
    loop.step(ControlMode::torque, -15);
    ++periods;
  }
  EXPECT_LT(periods, 40);
}

TYPED_TEST(DirectTorqueControllerOf, RestartsOnASpinningMachineThatStillHasFlux) {
  using T = TypeParam;
  Loop<T> loop;
  loop.machine.omega_m = 50;
  settle_at(loop, 15);
  for (int k = 0; k < 2000; ++k) loop.step(ControlMode::off, 0);
  EXPECT_GT(std::abs(loop.machine.psi_r), 0.3);
  double peak = 0;
  for (int k = 0; k < 4000; ++k) {
    loop.step(ControlMode::torque, 15);
    peak = std::max(peak, std::abs(loop.machine.i_s()));
  }
  EXPECT_LT(peak, 110);
  const Settled settled = settle_at(loop, 15);
  EXPECT_NEAR(settled.mean, 15, 2);
}

TYPED_TEST(DirectTorqueControllerOf, GatesAreOffUnlessTorqueOrFluxIsWanted) {
  using T = TypeParam;
  Loop<T> loop;
  for (int k = 0; k < 10; ++k) {
    loop.step(ControlMode::off, 15);
    EXPECT_EQ(loop.last(), (GatePattern{gates_off, loop.period_ns}));
  }
  loop.step(ControlMode::torque, 15);
  EXPECT_TRUE(is_driven(loop.last().last_state()));
  loop.step(ControlMode::off, 15);
  EXPECT_EQ(loop.last(), (GatePattern{gates_off, loop.period_ns}));
}

TYPED_TEST(DirectTorqueControllerOf, MagnetisesFirstAndThenGivesTorqueWithoutASurge) {
  using T = TypeParam;
  typename DirectTorqueController<T>::Parameters parameters;
  parameters.magnetiser.hand_over_current = T(16);
  Loop<T> loop{parameters};
  int periods = 0;
  for (; periods < 4000 && !loop.controller().estimate().magnetised; ++periods) {
    loop.step(ControlMode::magnetise, 15);
    EXPECT_NEAR(loop.machine.torque(), 0, 0.1);
  }
  EXPECT_TRUE(loop.controller().estimate().magnetised);
  EXPECT_NEAR(double(loop.controller().estimate().psi_s_magnitude), 1.1, 0.03);
  double peak = 0;
  for (int k = 0; k < 400; ++k) {
    loop.step(ControlMode::torque, 15);
    peak = std::max(peak, std::abs(loop.machine.i_s()));
  }
  EXPECT_LT(peak, 45);
}

TYPED_TEST(DirectTorqueControllerOf, NothingIsEverNaNFromZeroFluxOn) {
  using T = TypeParam;
  Loop<T> loop;
  for (int k = 0; k < 400; ++k) {
    loop.step(ControlMode::torque, k < 200 ? 0 : 15);
    const ControlEstimate<T> x = loop.controller().estimate();
    ASSERT_TRUE(std::isfinite(x.psi_s.alpha) && std::isfinite(x.psi_s.beta));
    ASSERT_TRUE(std::isfinite(x.psi_s_magnitude) && std::isfinite(x.torque));
    ASSERT_EQ(x.sector == 0, x.psi_s_magnitude == T(0));
    ASSERT_LE(x.sector, 6);
  }
}

TYPED_TEST(DirectTorqueControllerOf, IsAsNewAfterAReset) {
  using T = TypeParam;
  Loop<T> loop;
  settle_at(loop, 15);
  loop.controller().reset();
  const ControlEstimate<T> x = loop.controller().estimate();
  EXPECT_EQ(x.psi_s, SpaceVector<T>{});
  EXPECT_EQ(x.psi_s_magnitude, T(0));
  EXPECT_EQ(x.torque, T(0));
  EXPECT_EQ(x.sector, 0);
  EXPECT_FALSE(x.magnetised);
}

// The switching table starts from the sector that is kept: after a reset the same one as after power-up.
TYPED_TEST(DirectTorqueControllerOf, TheFirstStateAfterAResetIsThatAfterPowerUp) {
  using T = TypeParam;
  Measurement<T> nothing;
  nothing.u_dc = T(530);
  const auto first_state = [&](DirectTorqueController<T>& controller) {
    return controller.step(nothing, {ControlMode::torque, T(15)}).last_state();
  };
  Loop<T> loop;
  for (int k = 0; k < 4000; ++k) {
    loop.step(ControlMode::torque, 15);
    if (loop.controller().estimate().sector == 4) break;
  }
  ASSERT_EQ(loop.controller().estimate().sector, 4);
  loop.controller().reset();
  DirectTorqueController<T> fresh{{}};
  EXPECT_EQ(first_state(loop.controller()), first_state(fresh));
}

// The machine keeps its rotor flux, and the switching table starts from its sector.
TYPED_TEST(DirectTorqueControllerOf, TheSectorAfterARestartIsThatOfTheRotorFlux) {
  using T = TypeParam;
  Measurement<T> off;
  off.u_dc = T(530);
  off.applied = GatePattern{gates_off, 25'000};
  for (const int sector : {2, 4}) {
    Loop<T> loop;
    for (int k = 0; k < 4000; ++k) {
      loop.step(ControlMode::torque, 15);
      if (k > 2000 && loop.controller().estimate().sector == sector) break;
    }
    loop.controller().restart();
    (void)loop.controller().step(off, {});
    const ControlEstimate<T> x = loop.controller().estimate();
    SectorSelector<T> fresh{{}};
    EXPECT_EQ(x.sector, fresh.step(x.psi_s));
    EXPECT_GT(x.psi_s_magnitude, T(0.9));
  }
}

TYPED_TEST(DirectTorqueControllerOf, ReportsNoSectorWithoutFluxAndTheRightOneWhileMagnetising) {
  using T = TypeParam;
  typename DirectTorqueController<T>::Parameters parameters;
  parameters.sector.sector_start_deg = T(100);  // phase a, along which the flux is built up, lies in sector 5
  Loop<T> loop{parameters};
  EXPECT_EQ(loop.controller().estimate().sector, 0);
  loop.step(ControlMode::off, 0);
  EXPECT_EQ(loop.controller().estimate().sector, 0);
  for (int k = 0; k < 800; ++k) loop.step(ControlMode::magnetise, 0);
  EXPECT_GT(loop.controller().estimate().psi_s.alpha, T(0.1));
  EXPECT_EQ(loop.controller().estimate().sector, 5);
}

TYPED_TEST(DirectTorqueControllerOf, RefusesParametersThatCannotWork) {
  using T = TypeParam;
  using Parameters = typename DirectTorqueController<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  const auto refused = [](auto change) {
    Parameters parameters;
    change(parameters);
    return parameters.validate() != nullptr;
  };
  EXPECT_TRUE(refused([](Parameters& p) { p.period_ns = 0; }));
  EXPECT_TRUE(refused([](Parameters& p) { p.flux_reference = T(0); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.flux_reference = std::numeric_limits<T>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.flux_comparator.band = T(1.1); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.actuation_delay_periods = 2; }));
  EXPECT_TRUE(refused([](Parameters& p) { p.actuation_delay_periods = -1; }));
  EXPECT_TRUE(refused([](Parameters& p) { p.machine.r_s = T(0); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.torque_comparator.upper_band = T(0); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.sector.sector_start_deg = T(400); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.magnetiser.current_limit = T(0); }));
  // The current that carries 1.1 Wb is 12.9 A: below it magnetising would have to take flux away again.
  EXPECT_TRUE(refused([](Parameters& p) { p.magnetiser.hand_over_current = T(12.8); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.magnetiser.hand_over_current = T(14); }));
  EXPECT_FALSE(refused([](Parameters& p) { p.magnetiser.hand_over_current = T(15); }));
}

}  // namespace
}  // namespace sextant
