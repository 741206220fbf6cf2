#include "sextant/control/delay_predictor.hpp"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"

namespace sextant {
namespace {

/// An estimator that knows the machine's present flux and current: the flux is built by volt-seconds.
FluxTorqueEstimator<double> informed_estimator(const test::ReferenceMachine& machine) {
  FluxTorqueEstimator<double> estimator{{}};
  Measurement<double> m = machine.measure<double>({});
  estimator.step(m);
  const auto psi_0 = estimator.psi_s();
  const double missing_alpha = machine.psi_s.real() - psi_0.alpha;
  const double missing_beta = machine.psi_s.imag() - psi_0.beta;
  // One driven period of 1 ms whose voltage supplies exactly what is missing, in two segments' directions.
  const double r_i_alpha = 0.435 * machine.i_s().real() * 1e-3;
  const double r_i_beta = 0.435 * machine.i_s().imag() * 1e-3;
  const double u_alpha = (missing_alpha + r_i_alpha) / 1e-3;
  const double u_beta = (missing_beta + r_i_beta) / 1e-3;
  // u = t2 V2 + t1 V1 with V1 = 2/3 u_dc, V2 at 60°; the rest of the period is a zero vector.
  const double u_dc = 3000;
  const double t2 = u_beta / (2.0 / 3.0 * u_dc * std::sqrt(0.75));
  const double t1 = (u_alpha - t2 * u_dc / 3.0) / (2.0 / 3.0 * u_dc);
  EXPECT_GE(t1, 0.0);
  EXPECT_GE(t2, 0.0);
  EXPECT_LE(t1 + t2, 1.0);
  GatePattern pattern;
  pattern.append({switch_states[1], std::int32_t(std::lround(t1 * 1e6))});
  pattern.append({switch_states[2], std::int32_t(std::lround(t2 * 1e6))});
  pattern.append({switch_states[0], std::int32_t(1'000'000 - std::lround(t1 * 1e6) - std::lround(t2 * 1e6))});
  m.applied = pattern;
  m.u_dc = u_dc;
  estimator.step(m);
  return estimator;
}

test::ReferenceMachine loaded_machine() {
  test::ReferenceMachine machine;
  machine.omega_m = 80;
  machine.psi_s = {0.8, 0.75};
  machine.psi_r = {0.8, 0.68};
  return machine;
}

double prediction_error(std::int32_t duration_ns) {
  const test::ReferenceMachine machine = loaded_machine();
  FluxTorqueEstimator<double> estimator = informed_estimator(machine);
  const GatePattern in_flight{switch_states[3], duration_ns};
  const auto ahead = predict(estimator, {estimator.psi_s(), estimator.i_s()},
                             stator_voltage(in_flight.last_state(), machine.u_dc()), duration_ns * 1e-9);
  // The reference starts where the estimator believes to be, so that only the prediction errs.
  test::ReferenceMachine reference = machine;
  reference.psi_s = {estimator.psi_s().alpha, estimator.psi_s().beta};
  const auto psi_r = estimator.current_model().psi_r_from(estimator.psi_s(), estimator.i_s());
  reference.psi_r = {psi_r.alpha, psi_r.beta};
  reference.apply(in_flight);
  EXPECT_NEAR(ahead.psi_s.alpha, reference.psi_s.real(), 1e-3);
  return std::abs(std::complex<double>{ahead.i_s.alpha, ahead.i_s.beta} - reference.i_s());
}

TEST(DelayPredictor, EstimatorOfTheTestKnowsTheMachine) {
  const test::ReferenceMachine machine = loaded_machine();
  const auto estimator = informed_estimator(machine);
  EXPECT_NEAR(estimator.psi_s().alpha, machine.psi_s.real(), 1e-5);
  EXPECT_NEAR(estimator.psi_s().beta, machine.psi_s.imag(), 1e-5);
  EXPECT_NEAR(estimator.torque(), machine.torque(), 1e-2);
}

TEST(DelayPredictor, ErrsByThirdOrderInTheTimeAhead) {
  EXPECT_LT(prediction_error(25'000), 0.002);
  EXPECT_NEAR(prediction_error(100'000) / prediction_error(50'000), 8, 0.6);
  EXPECT_NEAR(prediction_error(50'000) / prediction_error(25'000), 8, 0.6);
}

}  // namespace
}  // namespace sextant
