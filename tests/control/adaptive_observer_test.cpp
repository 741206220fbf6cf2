#include "sextant/control/adaptive_observer.hpp"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

namespace sextant {
namespace {

using Complex = std::complex<double>;

/// A machine at constant rotor flux and torque whose shaft accelerates by this torque with three times its
/// own inertia: ψ_r at the angle θ, i_s = (ψ_r/L_m + j i_q) e^{jθ}, dθ/dt = p ω_m + R_r L_m i_q/(L_r ψ_r), ∫u
/// dt = R_s ∫i dt + k_r Δψ_r + σL_s Δi. Returns the mean error of the observer's torque, as a share.
double torque_error(const InductionMachineParameters<double>& m, double psi_r, double torque, double dt,
                    double from, double to) {
  const double gain = 1.5 * m.pole_pairs * m.k_r();
  const double i_q = torque / (gain * psi_r);
  const double slip = m.l_m * i_q / (m.tau_r() * psi_r);
  const double slope = m.pole_pairs * torque / (3.0 * m.inertia);
  const Complex i_of_flux{psi_r / m.l_m, i_q};
  AdaptiveObserver<double> observer{m, true};
  observer.set({psi_r, 0.0}, {i_of_flux.real(), i_of_flux.imag()}, from / m.pole_pairs);
  double theta = 0.0;
  double sum = 0.0;
  int steps = 0;
  for (double omega = from; omega < to; omega += slope * dt) {
    const double turn = (omega + 0.5 * slope * dt + slip) * dt;
    const Complex before = std::polar(1.0, theta);
    const Complex middle = std::polar(1.0, theta + 0.5 * turn);
    theta = std::remainder(theta + turn, 2.0 * 3.141592653589793);
    const Complex after = std::polar(1.0, theta);
    const Complex i_mean = i_of_flux * (before + 4.0 * middle + after) / 6.0;
    const Complex u = m.r_s * dt * i_mean + m.k_r() * psi_r * (after - before) +
                      m.sigma_l_s() * i_of_flux * (after - before);
    const SpaceVector<double> i{(i_of_flux * after).real(), (i_of_flux * after).imag()};
    observer.step({u.real(), u.imag()}, i, 0.0, dt);
    sum += 1.5 * m.pole_pairs * cross(observer.psi_s(i), i) / torque - 1.0;
    ++steps;
  }
  return sum / steps;
}

// From 0.25 to 200 kW: the acceleration is far below K/tau_r.
TEST(AdaptiveObserver, TheTorqueIsRightWhileAnyMachineAccelerates) {
  struct Case {
    const char* name;
    InductionMachineParameters<double> machine;
    double psi_r;
    double torque;
  };
  const Case cases[] = {
      {"250 W", {25, 22, 0.06, 0.06, 1.1, 2, 3e-4}, 0.85, 0.7},
      {"8 poles", {0.467, 0.380, 0.0033, 0.0033, 0.039674, 4, 0.2066}, 0.44, 33},
      {"45 kW", {0.057, 0.0316040816, 0.00112364373, 0.00112364373, 0.0255763563, 2, 0.8134}, 1.0, 250},
      {"200 kW", {0.012, 0.009, 1.4e-4, 1.6e-4, 5.2e-3, 3, 4}, 0.85, 1500}};
  for (const Case& c : cases) {
    for (const double dt : {50e-6, 125e-6}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << dt);
      EXPECT_LT(std::abs(torque_error(c.machine, c.psi_r, c.torque, dt, 60.0, 250.0)), 0.03);
    }
  }
}

}  // namespace
}  // namespace sextant
