#include "sextant/safety/monitored_flux.hpp"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

using Complex = std::complex<double>;

/// The solution of dψ/dt = (−1/τ_r + jω) ψ + L_m/τ_r i for a constant current.
Complex solution(const InductionMachineParameters<double>& m, Complex psi, Complex i, double omega_m,
                 double t) {
  const double rate = m.r_r / (m.l_lr + m.l_m);
  const Complex pole{-rate, m.pole_pairs * omega_m};
  const Complex end = -rate * m.l_m * i / pole;
  return end + (psi - end) * std::exp(pole * t);
}

template <class T>
class MonitoredFluxOf : public testing::Test {
 protected:
  InductionMachineParameters<double> machine{unlike_machine()};
  MonitoredFlux<T> flux{in_scalar<T>(machine)};

  [[nodiscard]] Complex value() const { return {double(flux.psi_r().alpha), double(flux.psi_r().beta)}; }
  void step(Complex i, double omega_m, double dt) {
    flux.step({T(i.real()), T(i.imag())}, T(omega_m), T(dt));
  }
  /// A flux by direct current for a long time.
  void magnetise(Complex i) {
    for (int k = 0; k < 100; ++k) step(i, 0.0, 0.1);
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(MonitoredFluxOf, Scalars);

TYPED_TEST(MonitoredFluxOf, DirectCurrentMakesTheFluxOfTheMagnetisingInductance) {
  const Complex i{20.0, -7.0};
  this->magnetise(i);
  EXPECT_LT(std::abs(this->value() - this->machine.l_m * i), 1e-6);
}

// Steps up to the largest that the series take, 0.25 rad and 0.05 of τ_r, and beyond.
TYPED_TEST(MonitoredFluxOf, OneStepWithoutCurrentTurnsAndShrinksToTheErrorOfTheSeries) {
  for (const double dt : {1e-4, 1e-3, 4.9e-3, 0.02}) {
    for (const double turn : {-0.249, -0.1, 0.03, 0.249, 1.0}) {
      SCOPED_TRACE(testing::Message() << dt << " s, " << turn << " rad");
      this->magnetise({20.0, -7.0});
      const Complex before = this->value();
      const double omega_m = turn / (this->machine.pole_pairs * dt);
      this->step({}, omega_m, dt);
      const Complex expected = solution(this->machine, before, {}, omega_m, dt);
      EXPECT_LT(std::abs(this->value() - expected), 1.5e-6 * std::abs(before));
    }
  }
}

TYPED_TEST(MonitoredFluxOf, OneStepAtRestAddsTheCurrentsPart) {
  for (const double dt : {1e-4, 4.9e-3, 0.02}) {
    this->magnetise({20.0, -7.0});
    const Complex i{-30.0, 40.0};
    const Complex expected = solution(this->machine, this->value(), i, 0.0, dt);
    this->step(i, 0.0, dt);
    EXPECT_LT(std::abs(this->value() - expected), 2e-6) << dt;
  }
}

// Half of the current's part comes before the turn: with all of it before or after, the angle is half a step
// off.
TYPED_TEST(MonitoredFluxOf, TheFluxOfASteadyStateIsThatOfTheCircuit) {
  for (const double omega_slip : {-30.0, 4.0, 15.0}) {
    for (const double omega_m : {-100.0, 60.0}) {
      const double dt = 2e-4;
      const EquivalentCircuit circuit{this->machine, omega_m, omega_slip, {25.0, 10.0}};
      const Complex turn = std::polar(1.0, circuit.omega_e * dt);
      Complex now = 1.0;
      for (int k = 0; k < 10'000; ++k) {
        const Complex mean = (0.5 * (1.0 + turn)) * now * circuit.i_s;
        now *= turn;
        now /= std::abs(now);
        this->step(mean, omega_m, dt);
      }
      const double square = std::norm(circuit.omega_e * dt) + std::norm(3.0 * omega_m * dt);
      EXPECT_LT(std::abs(this->value() - now * circuit.psi_r), (1e-4 + square) * std::abs(circuit.psi_r))
          << omega_slip << ' ' << omega_m;
    }
  }
}

}  // namespace
}  // namespace sextant
