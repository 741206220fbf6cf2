#include "sextant/plant/cvode_integrator.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

double relative_difference(const Plant& a, const Plant& b) {
  return (a.state() - b.state()).cwiseAbs().maxCoeff() / b.state().cwiseAbs().maxCoeff();
}

TEST(CvodeIntegrator, AgreesWithTheFixedStepOverASwitchingSequence) {
  const auto sequence = switching_sequence(4000, 21);
  Plant reference{DrivePlantParameters<double>{}};
  FixedStepIntegrator<Plant> fixed{FixedStepParameters{5'000}};
  ASSERT_TRUE(run(reference, fixed, sequence, supply()));
  ASSERT_GT(magnitude(reference.psi_s()), 0.1);
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    SCOPED_TRACE(int(method));
    CvodeParameters parameters{};
    parameters.method = method;
    parameters.relative_tolerance = 1e-10;
    parameters.flux_tolerance = 1e-12;
    Plant plant{DrivePlantParameters<double>{}};
    CvodeIntegrator<Plant> cvode{parameters};
    ASSERT_TRUE(run(plant, cvode, sequence, supply()));
    EXPECT_LT(magnitude(plant.psi_s() - reference.psi_s()), 1e-6 * magnitude(reference.psi_s()));
    EXPECT_LT(magnitude(plant.psi_r() - reference.psi_r()), 1e-6 * magnitude(reference.psi_r()));
    EXPECT_LT(magnitude(plant.i_s() - reference.i_s()), 1e-5 * magnitude(reference.i_s()));
    EXPECT_LT(relative_difference(plant, reference), 1e-6);
  }
}

/// Largest error of the torque over a switching sequence, one vector a period, by its peak.
double torque_error(const CvodeParameters& parameters) {
  Plant reference{DrivePlantParameters<double>{}};
  FixedStepIntegrator<Plant> fixed{FixedStepParameters{5'000}};
  Plant plant{DrivePlantParameters<double>{}};
  CvodeIntegrator<Plant> cvode{parameters};
  double error = 0.0;
  double peak = 0.0;
  for (const SwitchState state : switching_sequence(4000, 22)) {
    EXPECT_TRUE(run(reference, fixed, {state}, supply()));
    EXPECT_TRUE(run(plant, cvode, {state}, supply()));
    error = std::max(error, std::abs(plant.tau_e() - reference.tau_e()));
    peak = std::max(peak, std::abs(reference.tau_e()));
  }
  EXPECT_GT(peak, 10.0);
  return error / peak;
}

TEST(CvodeIntegrator, TorqueIsWithinAMillionthOfItsPeakWhereItStopsAtEachSwitching) {
  CvodeParameters parameters;
  parameters.at_switching = AtSwitching::stop;
  EXPECT_LT(torque_error(parameters), 1e-6);
}

TEST(CvodeIntegrator, TorqueIsWithinATenThousandthOfItsPeakAtTheDefaults) {
  EXPECT_LT(torque_error({}), 1e-4);
}

TEST(CvodeIntegrator, AgreesWithTheFixedStepThroughDiodeEvents) {
  const auto start = [] {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_inputs(supply());
    plant.set_fluxes({1.1, 0.0}, {1.05, 0.0});
    plant.set_speed(230.0);
    return plant;
  };
  std::vector<SwitchState> sequence(800, gates_off);
  for (std::size_t n = 200; n < 400; ++n) sequence[n] = {LegState::low, LegState::off, LegState::high};
  for (std::size_t n = 400; n < 500; ++n) sequence[n] = {LegState::low, LegState::off, LegState::off};
  Plant reference = start();
  FixedStepIntegrator<Plant> fixed{FixedStepParameters{1'000}};
  ASSERT_TRUE(run(reference, fixed, sequence, supply()));
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    SCOPED_TRACE(int(method));
    CvodeParameters parameters{};
    parameters.method = method;
    parameters.relative_tolerance = 1e-9;
    parameters.flux_tolerance = 1e-11;
    Plant plant = start();
    CvodeIntegrator<Plant> cvode{parameters};
    ASSERT_TRUE(run(plant, cvode, sequence, supply()));
    EXPECT_LT(magnitude(plant.psi_r() - reference.psi_r()), 1e-5);
    EXPECT_EQ(plant.inverter().ties(), reference.inverter().ties());
  }
}

}  // namespace
}  // namespace sextant
