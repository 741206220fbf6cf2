#include "sextant/drive/held_flux.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

namespace sextant {
namespace {

using Complex = std::complex<double>;
constexpr InductionMachineParameters<double> machine{};
constexpr double current_limit = 60;
constexpr double u_dc = 530;

/// A machine whose rotor flux k_r psi_r [Wb] stands at an angle, with a current beside it.
HeldFlux<>::Now now_at(double omega_m, double link, Complex main) {
  const SpaceVector<> i_s{12.0, -7.0};
  const SpaceVector<> psi_s = SpaceVector<>{main.real(), main.imag()} + machine.sigma_l_s() * i_s;
  return {psi_s, i_s, omega_m, link};
}

// What six steps have of the link: the amplitude of their fundamental, by its Fourier integral.
double six_step_fundamental() {
  constexpr int n = 60'000;
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.5) / n;
    const double step = std::floor(angle / (std::numbers::pi / 3)) * std::numbers::pi / 3;
    sum += 2.0 / 3.0 * u_dc * std::cos(angle - step - std::numbers::pi / 6) / n;
  }
  return sum;
}

TEST(HeldFlux, IsWhatSixStepsTurnWithTheRotor) {
  const HeldFlux<> held{machine, current_limit};
  for (const double omega_m : {-250.0, 200.0}) {
    const double flux = held.flux(now_at(omega_m, u_dc, std::polar(0.8, 1.0)), 0.0, 10.0);
    EXPECT_NEAR(flux, six_step_fundamental() / (machine.pole_pairs * std::abs(omega_m)), 1e-6);
  }
}

// The rotor circuit of the T-equivalent circuit, R_r i_r + j omega_slip psi_r = 0 with psi_r at rest: i_r is
// across psi_r, and makes the torque 3/2 p psi_r i_r.
TEST(HeldFlux, OfAGeneratorTurnsSlowerThanItsRotorByTheSlip) {
  const HeldFlux<> held{machine, current_limit};
  const double main = 0.6;
  const double psi_r = main * machine.l_r() / machine.l_m;
  for (const double omega_m : {-250.0, 200.0}) {
    const double torque = std::copysign(25.0, -omega_m);
    const double i_r = 25.0 / (1.5 * machine.pole_pairs * psi_r);
    const double omega_s = machine.pole_pairs * std::abs(omega_m) - machine.r_r * i_r / psi_r;
    EXPECT_NEAR(held.flux(now_at(omega_m, u_dc, std::polar(main, 1.0)), torque, 10.0),
                six_step_fundamental() / omega_s, 1e-6);
    EXPECT_NEAR(held.flux(now_at(omega_m, u_dc, std::polar(main, 1.0)), -torque, 10.0),
                six_step_fundamental() / (machine.pole_pairs * std::abs(omega_m)), 1e-6);
  }
}

TEST(HeldFlux, IsNoLimitWhereTheLinkHoldsEnough) {
  const HeldFlux<> held{machine, current_limit};
  EXPECT_TRUE(std::isinf(held.flux(now_at(100.0, u_dc, {1.0, 0.0}), 15.0, 1.1)));
  EXPECT_TRUE(std::isinf(held.flux(now_at(0.0, u_dc, {1.0, 0.0}), 15.0, 1.1)));
  EXPECT_TRUE(std::isinf(held.flux(now_at(200.0, std::nan(""), {1.0, 0.0}), 15.0, 1.1)));
}

// Below a link that has all but gone, the least flux of every current of that torque within the limit.
TEST(HeldFlux, LeavesTheCurrentWithinItsLimitBesideTheTorque) {
  const HeldFlux<> held{machine, current_limit};
  for (const double torque : {-60.0, 0.0, 30.0}) {
    for (const double main : {0.7, 1.0}) {
      const double i_q = torque / (1.5 * machine.pole_pairs * main);
      double least = 10;
      for (double i_d = -current_limit; i_d <= current_limit; i_d += 1e-3) {
        if (std::hypot(i_d, i_q) > current_limit) continue;
        least = std::min(least, std::abs(main + machine.sigma_l_s() * Complex{i_d, i_q}));
      }
      EXPECT_NEAR(held.flux(now_at(200.0, 1.0, std::polar(main, -2.0)), torque, 1.1), least, 1e-4);
    }
  }
}

TEST(HeldFlux, IsFiniteWithoutFlux) {
  const HeldFlux<> held{machine, current_limit};
  EXPECT_TRUE(std::isfinite(held.flux({{}, {}, 200.0, u_dc}, 0.0, 1.1)));
  EXPECT_TRUE(std::isfinite(held.flux({{}, {}, 200.0, u_dc}, 15.0, 1.1)));
  EXPECT_FALSE(std::isnan(held.flux({{}, {}, 200.0, u_dc}, -15.0, 1.1)));
}

}  // namespace
}  // namespace sextant
