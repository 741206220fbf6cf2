#include "sextant/safety/current_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "safety/steady_machine.hpp"
#include "sextant/safety/applied_volt_seconds.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;

template <class T>
class CurrentPredictionOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CurrentPredictionOf, Scalars);

// Phasors of a machine in steady state, down to 21 periods a turn: what a period changes is known exactly.
TYPED_TEST(CurrentPredictionOf, IsTheChangeOfTheCurrentsOfASteadyMachine) {
  using T = TypeParam;
  const InductionMachineParameters<double> paper{};
  InductionMachineParameters<T> machine{};
  for (const double omega_m : {-6000.0, -300.0, 20.0, 1000.0, 6000.0}) {
    const SteadyMachine steady = SteadyMachine::of_torque(paper, 0.05, omega_m, 1.0);
    CurrentPrediction<T> prediction{machine, {}, period_ns};
    double largest = 0.0;
    for (int n = 0; n <= 200; ++n) {
      const Measurement<T> m = steady.template measurement<T>(n);
      const SpaceVector<double> psi_r = steady.psi_r(double(n) * SteadyMachine::dt);
      const SpaceVector<T> flux{T(psi_r.alpha), T(psi_r.beta)};
      if (n == 0) {
        prediction.restart(m.i_abc, flux);
        continue;
      }
      const Measurement<T> before = steady.template measurement<T>(n - 1);
      const PredictedChange<T> change = prediction.step(
          m.i_abc, {.psi_r = flux}, applied_volt_seconds(m.applied, m.u_dc), m.u_dc, T(SteadyMachine::dt));
      largest = std::max({largest, std::abs(double(change.v.a - change.e.a - (m.i_abc.a - before.i_abc.a))),
                          std::abs(double(change.v.b - change.e.b - (m.i_abc.b - before.i_abc.b))),
                          std::abs(double(change.v.c - change.e.c - (m.i_abc.c - before.i_abc.c)))});
      EXPECT_NEAR(double(change.turn), std::sin(steady.omega_e() * SteadyMachine::dt), 1e-4);
      const double e =
          magnitude(clarke(ThreePhase<double>{double(change.e.a), double(change.e.b), double(change.e.c)}));
      EXPECT_NEAR(double(change.uncertainty), e + 0.02 * 2.0 / 3.0 * 2000.0 * 25e-6 / paper.sigma_l_s(),
                  1e-3);
    }
    // A nanosecond of a segment is 2000 V · 1 ns/σL_s = 0.4 mA; the currents move by up to 5 A a period.
    EXPECT_LT(largest, 5e-3) << omega_m;
  }
}

// The machine's flux may be another than the model's by more than that: at 2π · 50 rad/s a flux turns by
// 7.85 mrad a period, and 0.9 Wb of it move a phase by 1.31 A.
TYPED_TEST(CurrentPredictionOf, AFluxThatMayBeWrongByMoreThanItselfMakesEUncertainByAsMuch) {
  using T = TypeParam;
  const double turn = 314.159265 * 25e-6;
  const InductionMachineParameters<double> paper{};
  const double per_weber = paper.k_r() * turn / paper.sigma_l_s();
  for (const double flux : {0.9, 0.3, 0.0}) {
    for (const double error : {0.0, 0.2, 0.9}) {
      for (const double sign : {-1.0, 1.0}) {
        CurrentPrediction<T> prediction{InductionMachineParameters<T>{}, {}, period_ns};
        prediction.restart({}, {T(flux), T(0)});
        const SpaceVector<double> end = polar(flux, sign * turn);
        const PredictedChange<T> change =
            prediction.step({}, {{T(end.alpha), T(end.beta)}, T(error), T(sign * turn)}, {}, T(0), T(25e-6));
        EXPECT_NEAR(double(change.uncertainty), per_weber * std::max(flux, error), 1e-3);
        EXPECT_NEAR(double(change.error_turn), per_weber * error * turn, 1e-5);
        EXPECT_NEAR(double(change.rotor_turn), sign * turn, 1e-6);
      }
    }
  }
}

// Of a stated error of the voltage, 3 V, twice as much moves a phase by 6 V · 25 µs/σL_s.
TYPED_TEST(CurrentPredictionOf, AStatedErrorOfTheVoltageIsAllowedForTwice) {
  using T = TypeParam;
  const InductionMachineParameters<double> paper{};
  CurrentPrediction<T> prediction{InductionMachineParameters<T>{}, {.voltage_error = T(3)}, period_ns};
  prediction.restart({}, {});
  const PredictedChange<T> change = prediction.step({}, {}, {}, T(0), T(25e-6));
  EXPECT_NEAR(double(change.uncertainty), 6 * 25e-6 / paper.sigma_l_s(), 1e-5);
}

// Dead times of 3 µs in a period of 125 µs take 12 V of a leg at 500 V, a threshold 1 V; of the phase's
// voltage two thirds.
TYPED_TEST(CurrentPredictionOf, WhatHangsOnTheSignOfTheCurrentIsToldApart) {
  using T = TypeParam;
  const InductionMachineParameters<double> paper{};
  CurrentPrediction<T> prediction{
      InductionMachineParameters<T>{}, {.dead_time_ns = 3000, .threshold_voltage = T(1)}, 125'000};
  prediction.restart({}, {});
  const PredictedChange<T> change = prediction.step({}, {}, {}, T(500), T(250e-6));
  EXPECT_NEAR(double(change.by_sign), 2.0 / 3.0 * 13.0 * 250e-6 / paper.sigma_l_s(), 1e-5);
}

TYPED_TEST(CurrentPredictionOf, ARestartBeginsAtTheCurrentsAndTheFluxGiven) {
  using T = TypeParam;
  CurrentPrediction<T> prediction{InductionMachineParameters<T>{}, {}, period_ns};
  prediction.restart({T(10), T(-5), T(-5)}, {T(0.9), T(0)});
  const PredictedChange<T> change =
      prediction.step({T(10), T(-5), T(-5)}, {.psi_r = {T(0.9), T(0)}}, {}, T(0), T(25e-6));
  // R_s i T/σL_s of the paper's machine: 0.435 Ω · 10 A · 25 µs/4.7326 mH.
  EXPECT_NEAR(double(change.e.a), 0.435 * 10.0 * 25e-6 / InductionMachineParameters<double>{}.sigma_l_s(),
              1e-6);
  EXPECT_EQ(change.turn, T(0));
}

}  // namespace
}  // namespace sextant
