#include "sextant/safety/speed_plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

/// A rotor flux that turns at a known electrical frequency, a stator current of any size in it, and the volt-
/// seconds that both need: ∫u dt = Δψ + σL_s Δi + R_s ∫i dt, in closed form.
template <class T>
class SpeedPlausibilityOf : public testing::Test {
 protected:
  static constexpr std::int32_t period_ns = 25'000;
  using Parameters = typename SpeedPlausibility<T>::Parameters;

  void run(double seconds) {
    const double dt = periods * period_ns * 1e-9;
    for (long left = std::lround(seconds / dt); left > 0; --left) {
      const double angle = omega_e * dt;
      const SpaceVector<double> psi = polar(flux, theta + angle) - polar(flux, theta);
      const SpaceVector<double> i0 = polar(current, theta + lead);
      const SpaceVector<double> i1 = polar(current, theta + angle + lead);
      const double r_s = r_s_share * machine.r_s;
      const SpaceVector<double> u = psi + machine.sigma_l_s() * (i1 - i0) + (0.5 * r_s * dt) * (i0 + i1);
      theta = std::remainder(theta + angle, 2.0 * 3.141592653589793);
      // `flux` is that of the rotor, times k_r.
      const SpaceVector<double> psi_s = polar(flux, theta) + machine.sigma_l_s() * i1;
      speed.step(scalar(inverse_clarke(i1)), scalar(inverse_clarke(u)), T(omega_m), T(torque()),
                 T(magnitude(psi_s)), T(1.1), period_ns * periods);
    }
  }
  /// Of flux and current as they stand to each other. [N·m]
  [[nodiscard]] double torque() const { return 1.5 * 2.0 * flux * current * std::sin(lead); }
  static ThreePhase<T> scalar(const ThreePhase<double>& x) { return {T(x.a), T(x.b), T(x.c)}; }

  InductionMachineParameters<double> machine{};
  int periods{1};         ///< between two measurements
  double omega_e{160.0};  ///< of the flux [rad/s]
  double omega_m{80.0};   ///< measured [rad/s]
  double flux{1.1};       ///< [Wb]
  double current{20.0};   ///< [A]
  double lead{0.0};       ///< of the current before the flux [rad]
  double r_s_share{1.0};  ///< of the machine's true R_s against the monitor's
  double theta{0.3};
  SpeedPlausibility<T> speed{Parameters{}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SpeedPlausibilityOf, Scalars);

TYPED_TEST(SpeedPlausibilityOf, TheErrorIsThatOfTheMeasuredSpeed) {
  for (const double omega : {-400.0, -80.0, -20.0, 20.0, 80.0, 400.0}) {
    for (const double error : {-30.0, 0.0, 30.0}) {
      SCOPED_TRACE(testing::Message() << omega << ' ' << error);
      this->speed.restart({});
      this->omega_e = 2.0 * omega;
      this->omega_m = omega + error;
      this->run(0.1);
      const double tolerance = 0.1;
      EXPECT_FALSE(this->speed.is_off_by(TypeParam(std::abs(error) + tolerance)));
      if (error != 0.0) {
        EXPECT_TRUE(this->speed.is_off_by(TypeParam(std::abs(error) - tolerance)));
      }
    }
  }
}

// As of reads of several records, up to 1 ms together: 46° of the flux.
TYPED_TEST(SpeedPlausibilityOf, TheErrorIsTheSameOverIntervalsOfAnyLength) {
  std::mt19937 random{11};
  for (const double omega : {-400.0, -20.0, 20.0, 400.0}) {
    for (const double error : {-30.0, 0.0, 30.0}) {
      SCOPED_TRACE(testing::Message() << "seed 11, " << omega << ' ' << error);
      this->speed.restart({});
      this->omega_e = 2.0 * omega;
      this->omega_m = omega + error;
      const double tolerance = 0.1 + 0.01 * std::abs(omega);
      for (int k = 0; k < 1500; ++k) {
        const int lengths[] = {1, 2, 3, 7, 40};
        this->periods = lengths[std::uniform_int_distribution<std::size_t>{0, 4}(random)];
        this->run(this->periods * 25e-6);
        if (k < 800) continue;
        ASSERT_FALSE(this->speed.is_off_by(TypeParam(std::abs(error) + tolerance))) << k;
        ASSERT_TRUE(error == 0.0 || this->speed.is_off_by(TypeParam(std::abs(error) - tolerance))) << k;
      }
    }
  }
}

TYPED_TEST(SpeedPlausibilityOf, AStatorResistanceThatDiffersDoesNotMatter) {
  for (const double share : {0.5, 1.5}) {
    this->r_s_share = share;
    this->omega_e = 40.0;
    this->omega_m = 20.0;
    this->speed.restart({});
    this->run(0.1);
    EXPECT_FALSE(this->speed.is_off_by(TypeParam(0.2))) << share;
  }
}

TYPED_TEST(SpeedPlausibilityOf, TheSlipOfTheTorqueIsTakenOffAndAsMuchIsAllowedFor) {
  // ω_slip = R_r τ_e / (3/2 p ψ_r²), with k_r ψ_r = 1.1 Wb
  this->current = 45.0;
  this->lead = 1.3;
  const double k_r = this->machine.k_r();
  const double slip = this->machine.r_r * this->torque() * k_r * k_r / (1.5 * 2.0 * 1.1 * 1.1);
  for (const double error : {-40.0, 0.0, 40.0}) {
    this->omega_e = 160.0 + slip;
    this->omega_m = 80.0 + error;
    this->speed.restart({});
    this->run(0.1);
    const double allowed = 0.5 * slip;  // as a mechanical speed
    EXPECT_FALSE(this->speed.is_off_by(TypeParam(std::max(0.5, std::abs(error) - allowed + 0.5))));
    if (error != 0.0) {
      EXPECT_TRUE(this->speed.is_off_by(TypeParam(std::abs(error) - allowed - 0.5)));
    }
  }
}

TYPED_TEST(SpeedPlausibilityOf, AReadingThatIsLostShowsWithinFiveMilliseconds) {
  this->run(0.1);
  this->omega_m = 0.0;
  this->run(0.005);
  EXPECT_TRUE(this->speed.is_off_by(TypeParam(60)));
}

// At 160 rad/s the leak of 150 rad/s leaves 0.80 Wb of 1.1 Wb: an error of 50 V, of which two make 0.67 Wb,
// is below that, one of 65 V, 0.87 Wb, is not.
TYPED_TEST(SpeedPlausibilityOf, AFluxThatTheErrorOfTheVoltageMayMakeDoesNotCount) {
  using T = TypeParam;
  for (const double error : {50.0, 65.0}) {
    typename TestFixture::Parameters p{};
    p.voltage_error = T(error);
    this->speed = SpeedPlausibility<T>{p};
    this->omega_m = 160.0 / 2.0 + 30.0;
    this->run(0.1);
    EXPECT_EQ(this->speed.is_off_by(T(25)), error < 60.0) << error;
  }
}

TYPED_TEST(SpeedPlausibilityOf, NothingCountsBeforeItHasSettledNorWithoutFlux) {
  this->omega_m = 0.0;
  this->run(0.039);
  EXPECT_FALSE(this->speed.is_off_by(TypeParam(28)));
  this->run(0.003);
  EXPECT_TRUE(this->speed.is_off_by(TypeParam(28)));
  this->speed.restart({});
  EXPECT_FALSE(this->speed.is_off_by(TypeParam(28)));
  this->flux = 0.1;
  this->run(0.2);
  EXPECT_FALSE(this->speed.is_off_by(TypeParam(28)));
}

}  // namespace
}  // namespace sextant
