#include "sextant/plant/induction_machine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace sextant {
namespace {

using Complex = std::complex<double>;
using Vector4 = Eigen::Vector4d;

constexpr double pi = std::numbers::pi;

/// The machine at constant speed as x' = A x + [u_s; 0], built column by column.
Vector4 slope(const InductionMachine<double>& machine, const Vector4& x, SpaceVector<double> u_s,
              double omega_m) {
  const SpaceVector<double> psi_s{x[0], x[1]};
  const SpaceVector<double> psi_r{x[2], x[3]};
  const SpaceVector<double> i_s = machine.stator_current(psi_s, psi_r);
  const SpaceVector<double> i_r = machine.rotor_current(psi_s, psi_r);
  const SpaceVector<double> ds = machine.stator_flux_derivative(u_s, i_s);
  const SpaceVector<double> dr = machine.rotor_flux_derivative(i_r, psi_r, omega_m);
  return {ds.alpha, ds.beta, dr.alpha, dr.beta};
}

template <class Voltage>
Vector4 integrate(const InductionMachine<double>& machine, Vector4 x, double omega_m, double duration,
                  double h, Voltage voltage) {
  const auto steps = int(std::lround(duration / h));
  for (int n = 0; n < steps; ++n) {
    const double t = n * h;
    const Vector4 k1 = slope(machine, x, voltage(t), omega_m);
    const Vector4 k2 = slope(machine, x + h / 2 * k1, voltage(t + h / 2), omega_m);
    const Vector4 k3 = slope(machine, x + h / 2 * k2, voltage(t + h / 2), omega_m);
    const Vector4 k4 = slope(machine, x + h * k3, voltage(t + h), omega_m);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return x;
}

TEST(InductionMachine, FluxLinkagesFollowFromCurrents) {
  const InductionMachineParameters<double> p{};
  const InductionMachine<double> machine{p};
  const SpaceVector<double> i_s{7.0, -3.0};
  const SpaceVector<double> i_r{-2.0, 5.0};
  const SpaceVector<double> psi_s = p.l_s() * i_s + p.l_m * i_r;
  const SpaceVector<double> psi_r = p.l_m * i_s + p.l_r() * i_r;
  const SpaceVector<double> stator = machine.stator_current(psi_s, psi_r);
  const SpaceVector<double> rotor = machine.rotor_current(psi_s, psi_r);
  EXPECT_NEAR(stator.alpha, i_s.alpha, 1e-12);
  EXPECT_NEAR(stator.beta, i_s.beta, 1e-12);
  EXPECT_NEAR(rotor.alpha, i_r.alpha, 1e-12);
  EXPECT_NEAR(rotor.beta, i_r.beta, 1e-12);
  const double energy =
      0.75 * (p.l_ls * dot(i_s, i_s) + p.l_lr * dot(i_r, i_r) + p.l_m * dot(i_s + i_r, i_s + i_r));
  EXPECT_NEAR(machine.magnetic_energy(psi_s, psi_r), energy, 1e-12 * energy);
}

TEST(InductionMachine, SteadyStateIsTheEquivalentCircuit) {
  const InductionMachineParameters<double> p{};
  const InductionMachine<double> machine{p};
  const double amplitude = 162.6;
  const double omega_e = 2 * pi * 50;
  const double duration = 4.0;
  for (const double slip : {-0.05, 0.0, 0.01, 0.05, 0.3, 1.0}) {
    SCOPED_TRACE(slip);
    const double omega_m = (1 - slip) * omega_e / p.pole_pairs;
    // T-equivalent circuit: stator impedance in series with magnetising branch parallel to the rotor's.
    const Complex j{0, 1};
    const Complex magnetising = j * omega_e * p.l_m;
    Complex parallel = magnetising;
    Complex rotor_share = 0;
    if (slip != 0.0) {
      const Complex rotor = p.r_r / slip + j * omega_e * p.l_lr;
      parallel = magnetising * rotor / (magnetising + rotor);
      rotor_share = magnetising / (magnetising + rotor);
    }
    const Complex i_s = amplitude / (p.r_s + j * omega_e * p.l_ls + parallel);
    const double rotor_power = slip == 0.0 ? 0.0 : 1.5 * std::norm(i_s * rotor_share) * p.r_r / slip;
    const double torque = rotor_power * p.pole_pairs / omega_e;

    const Vector4 x = integrate(machine, Vector4::Zero(), omega_m, duration, 25e-6,
                                [&](double t) { return polar(amplitude, omega_e * t); });
    const SpaceVector<double> i = machine.stator_current({x[0], x[1]}, {x[2], x[3]});
    const Complex turned = Complex{i.alpha, i.beta} * std::polar(1.0, -omega_e * duration);
    EXPECT_NEAR(std::abs(turned - i_s), 0.0, 1e-3 * std::abs(i_s));
    EXPECT_NEAR(machine.torque({x[0], x[1]}, i), torque, 1e-3 * std::max(std::abs(torque), 0.1));
  }
}

/// An eigenvalue of the machine at zero stator voltage, and its eigenvector: flux linkages of stator and
/// rotor.
struct Mode {
  Complex lambda;
  std::array<Complex, 2> v;
};

/// The real form of flux linkages.
Vector4 state_of(Complex psi_s, Complex psi_r) {
  return {psi_s.real(), psi_s.imag(), psi_r.real(), psi_r.imag()};
}

/// Both modes of the textbook matrix in psi_s, psi_r, written from the resistances and inductances alone, by
/// the quadratic equation of its eigenvalues.
std::array<Mode, 2> textbook_modes(const InductionMachineParameters<double>& p, double omega_m) {
  const double delta = p.l_s() * p.l_r() - p.l_m * p.l_m;
  const Complex a11 = -p.r_s * p.l_r() / delta;
  const Complex a12 = p.r_s * p.l_m / delta;
  const Complex a21 = p.r_r * p.l_m / delta;
  const Complex a22 = {-p.r_r * p.l_s() / delta, double(p.pole_pairs) * omega_m};
  const Complex mean = (a11 + a22) / 2.0;
  const Complex root = std::sqrt(mean * mean - (a11 * a22 - a12 * a21));
  const auto mode = [&](Complex lambda) {
    const Complex v = lambda - a11;
    const double length = std::hypot(std::abs(a12), std::abs(v));
    return Mode{lambda, {a12 / length, v / length}};
  };
  return {mode(mean + root), mode(mean - root)};
}

TEST(InductionMachine, ZeroStatorVoltageDecaysWithTheEigenvaluesOfTheMachine) {
  const InductionMachineParameters<double> p{};
  const InductionMachine<double> machine{p};
  for (const double omega_m : {0.0, 40.0, -140.0}) {
    SCOPED_TRACE(omega_m);
    for (const auto& [lambda, v] : textbook_modes(p, omega_m)) {
      // The equations have the mode: A v = λ v.
      const Vector4 derivative = slope(machine, state_of(v[0], v[1]), {}, omega_m);
      EXPECT_LT((derivative - state_of(lambda * v[0], lambda * v[1])).norm(), 1e-9 * std::abs(lambda));
      // The mode stays on its eigenvector and is scaled by exp(λ t).
      const double duration = 0.01;
      const Vector4 x = integrate(machine, state_of(v[0], v[1]), omega_m, duration, 10e-6,
                                  [](double) { return SpaceVector<double>{}; });
      const Complex factor = std::exp(lambda * duration);
      EXPECT_NEAR(std::abs(Complex(x[0], x[1]) - factor * v[0]), 0.0, 1e-9);
      EXPECT_NEAR(std::abs(Complex(x[2], x[3]) - factor * v[1]), 0.0, 1e-9);
    }
  }
}

TEST(InductionMachine, OpenStatorDecaysWithTheRotorTimeConstant) {
  const InductionMachineParameters<double> p{};
  const InductionMachine<double> machine{p};
  const SpaceVector<double> psi_r{0.9, 0.2};
  const SpaceVector<double> i_r = machine.rotor_current(machine.stator_flux({}, psi_r), psi_r);
  const SpaceVector<double> d = machine.rotor_flux_derivative(i_r, psi_r, 0.0);
  EXPECT_NEAR(d.alpha, -psi_r.alpha / p.tau_r(), 1e-12);
  EXPECT_NEAR(d.beta, -psi_r.beta / p.tau_r(), 1e-12);
}

TEST(InductionMachine, FloatAgreesWithDouble) {
  const InductionMachine<double> d{InductionMachineParameters<double>{}};
  const InductionMachine<float> f{InductionMachineParameters<float>{}};
  const SpaceVector<double> i_d = d.stator_current({1.1, 0.1}, {1.0, 0.0});
  const SpaceVector<float> i_f = f.stator_current({1.1F, 0.1F}, {1.0F, 0.0F});
  EXPECT_NEAR(double(i_f.alpha), i_d.alpha, 2e-4);
  EXPECT_NEAR(double(i_f.beta), i_d.beta, 2e-4);
}

}  // namespace
}  // namespace sextant
