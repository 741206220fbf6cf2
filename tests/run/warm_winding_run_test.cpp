// Runs of a drive whose R_s follows the temperature of its winding: by a sensor on a plant that is warm, and
// by the drive's thermal model against the exponential of its constant loss.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "run/period_by_period.hpp"

namespace sextant {
namespace {

constexpr int paper = 1;
constexpr double r_s = 0.435;  // of the paper's machine [Ω]
constexpr double copper = 0.00393;

using Settings = std::vector<std::string>;

/// A plant whose winding is at 140 °C and stays there; its resistances hold at 20 °C.
ScenarioConfig warm_config(double omega_m, Settings set) {
  set.insert(set.end(),
             {"plant.integrator=fixed", "control.adapts_parameters=false",
              "plant.thermal.winding_j_per_k=1e9", "plant.thermal.rotor_j_per_k=1e9",
              "plant.thermal.housing_j_per_k=1e9", "plant.thermal.winding_to_ambient_w_per_k=1",
              "plant.thermal.rotor_to_ambient_w_per_k=1", "plant.thermal.housing_to_ambient_w_per_k=1",
              "plant.thermal.winding_c=140", "protection.winding.warning_c=150"});
  return machine_config(
      test_machines[paper],
      {.controller = "foc", .omega_m = omega_m, .end_s = 1.0, .torque = "[[0, 0], [0.3, 40]]", .set = set});
}

/// Mean torque error of the last 0.3 s. [N·m]
double torque_error(const ScenarioConfig& config, double& r_s_in_use) {
  double sum = 0;
  int count = 0;
  go_through<MeteredPowerStage>(config, [&](double t, const Telemetry<double>& x, const auto& io) {
    r_s_in_use = x.r_s;
    if (t < 0.7) return;
    sum += io.plant().tau_e() - 40;
    ++count;
  });
  return sum / count;
}

// The observer has no R_s of its own: near standstill the error of R_s i is one of the flux.
TEST(WarmWindingRun, ASensorGivesTheResistanceOfTheWarmMachine) {
  const Settings low{"control.flux_estimator=observer"};
  Settings told = low;
  told.insert(told.end(), {"control.r_s_per_k=0.00393", "plant.measures_winding_temperature=true"});
  double used = 0;
  const double cold = torque_error(warm_config(10, low), used);
  EXPECT_NEAR(used, r_s, 1e-9);
  const double warm = torque_error(warm_config(10, told), used);
  EXPECT_NEAR(used, r_s * (1 + copper * 120), 1e-5);
  EXPECT_LT(std::abs(warm), 0.2);
  EXPECT_GT(std::abs(cold), 2 * std::abs(warm) + 0.2);
}

// At constant torque the loss is constant: Δ = Δ_n (i/i_n)² (1 − e^(−t/τ)), and R_s with it, in steps of 0.1
// s.
TEST(WarmWindingRun, TheModelGivesTheExponentialOfAConstantLoss) {
  const double i_n = 10, rise = 60, tau = 1;
  const ScenarioConfig config = machine_config(
      test_machines[paper],
      {.omega_m = 50,
       .end_s = 2.5,
       .torque = "[[0, 30]]",
       .set = {"control.adapts_parameters=false", "control.r_s_per_k=0.00393", "control.r_s_reference_c=25",
               "protection.winding.nominal_current_a=10", "protection.winding.nominal_rise_k=60",
               "protection.winding.time_constant_s=1", "protection.winding.ambient_c=25"}});
  double begin_t = -1, begin_rise = 0, squares = 0, worst = 0, last = 0;
  int count = 0;
  std::vector<std::pair<double, double>> course;
  go_through<MeteredPowerStage>(config, [&](double t, const Telemetry<double>& x, const auto&) {
    last = x.r_s;
    if (t < 0.5) return;
    if (begin_t < 0) {
      begin_t = t;
      begin_rise = (x.r_s / r_s - 1) / copper;
    }
    const ThreePhase<double>& i = x.i_abc;
    squares += (i.a * i.a + i.b * i.b + i.c * i.c) / 3;
    ++count;
    course.emplace_back(t - begin_t, (x.r_s / r_s - 1) / copper);
  });
  const double final_rise = rise * squares / count / (i_n * i_n);
  ASSERT_GT(final_rise, 20);
  for (const auto& [t, found] : course) {
    worst = std::max(worst, std::abs(found - final_rise - (begin_rise - final_rise) * std::exp(-t / tau)));
  }
  // A step of the model takes a tenth of the way that is left.
  EXPECT_LT(worst, 0.1 * (final_rise - begin_rise));
  EXPECT_NEAR(last, r_s * (1 + copper * (final_rise + (begin_rise - final_rise) * std::exp(-2.0 / tau))),
              1e-2 * last);
}

// Off, a warm plant and a model change nothing.
TEST(WarmWindingRun, WithoutACoefficientNothingChanges) {
  double plain = 0, with_sensor = 0, used = 0;
  plain = torque_error(warm_config(10, {}), used);
  with_sensor = torque_error(
      warm_config(10, {"plant.measures_winding_temperature=true", "protection.winding.nominal_current_a=50"}),
      used);
  EXPECT_EQ(plain, with_sensor);
  EXPECT_EQ(used, r_s);
}

}  // namespace
}  // namespace sextant
