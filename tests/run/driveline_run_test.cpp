// A drive on a load behind a driveline, against the closed forms of two masses, and the balance of its
// energies.

#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/run/scenario_commands.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

using Shaft = Driveline<>;
using Stage = MeteredPowerStageOf<Shaft>;

constexpr int paper = 1;
constexpr std::int64_t period_ns = 50'000;

/// On a shaft that is free to turn.
ScenarioConfig config_with(const DrivelineParameters<>& shaft, const std::string& torque, double end_s,
                           double tau_l = 0) {
  ScenarioConfig config = machine_config(
      test_machines[paper], {.controller = "foc", .period_us = 50, .end_s = end_s, .torque = torque});
  config.drive.plant.driveline = shaft;
  config.drive.plant.integrator = IntegratorKind::fixed;
  config.scenario.load = {.load_torque = ProfileParameters{.value = tau_l}};
  return config;
}

MilResult run_behind(const ScenarioConfig& config) {
  return with_appended(config.drive.plant, [&]<class Appended>(std::type_identity<Appended>) {
    MeteredPowerStageOf<Appended> stage{config.drive.plant, config.scenario.load};
    const auto controller = make_controller(config.drive);
    Drive<double> drive{config.drive.drive, *controller};
    return MilRunner{drive, stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
  });
}

struct NoTelemetry {
  void push(const Telemetry<double>&) noexcept SEXTANT_NONBLOCKING {}
};

// Friction, shaft, gap and load over motoring and braking.
TEST(DrivelineRun, EnergyClosesOverTheRun) {
  for (const IntegratorKind integrator :
       {IntegratorKind::fixed, IntegratorKind::erk, IntegratorKind::cvode}) {
    for (const double capacitance : {0.0, 1e-3}) {
      SCOPED_TRACE(std::to_string(int(integrator)) + ", " + std::to_string(capacitance) + " F");
      // Within a gap the shaft may end without twist.
      const double gap = capacitance > 0 ? 0.0 : 0.03;
      auto config = config_with({0.2, 800, 0.4, gap}, "[[0, 0], [0.3, 40], [0.5, -60], [0.7, 20]]", 0.9, 5);
      config.drive.plant.integrator = integrator;
      config.drive.plant.plant.viscous_friction = 0.01;
      if (capacitance > 0) config.drive.plant.link = {capacitance, 0.2};
      config.scenario.metrics.from_ns = 0;
      const MilResult result = run_behind(config);
      EXPECT_FALSE(result.faults.any());
      const MetricList& m = result.metrics;
      EXPECT_LT(m[Metric::energy_unaccounted], 1e-6);
      for (const Metric each : {Metric::energy_friction, Metric::energy_damping, Metric::energy_kinetic})
        EXPECT_GT(m[each], 0.1);
      EXPECT_GT(std::abs(m[Metric::energy_load]), 0.1);
      if (gap == 0) {
        EXPECT_GT(std::abs(m[Metric::energy_elastic]), 1e-3);
      }
      const double given = m[Metric::energy_friction] + m[Metric::energy_damping] + m[Metric::energy_load] +
                           m[Metric::energy_kinetic] + m[Metric::energy_elastic];
      EXPECT_NEAR(given, m[Metric::energy_shaft], 1e-6 * (std::abs(given) + m[Metric::energy_copper]));
    }
  }
}

// A constant torque accelerates both masses alike: the shaft has the load's share of it.
TEST(DrivelineRun, TheShaftCarriesTheLoadsShareOfTheTorque) {
  constexpr double torque = 40, tau_l = 10, j_2 = 0.2;
  auto config = config_with({j_2, 800, 4}, "[[0, 0], [0.3, 40]]", 0.8, tau_l);
  const MilResult result = run_behind(config);
  EXPECT_FALSE(result.faults.any());
  const MetricList& m = result.metrics;
  const double j = test_machines[paper].parameters.inertia;
  const double made = torque + m[Metric::torque_bias];
  const double carried = tau_l + (made - tau_l) * j_2 / (j + j_2);
  EXPECT_NEAR(m[Metric::shaft_torque_min], carried, 0.5);
  EXPECT_NEAR(m[Metric::shaft_torque_max], carried, 0.5);
  EXPECT_LT(m[Metric::shaft_torque_min], m[Metric::shaft_torque_max]);
  // Over the window of 100 ms.
  EXPECT_NEAR(m[Metric::load_speed_max] - m[Metric::load_speed_min], (made - tau_l) / (j + j_2) * 0.1, 0.05);
}

// A swing of the machine's torque at √(c/J_2) is absorbed by the load, and at √(c (1/J + 1/J_2)) it
// resonates:
//   ω_1/tau_e = (J_2 s² + d s + c)/(s (J J_2 s² + (J + J_2)(d s + c))), s = jω.
TEST(DrivelineRun, TheMotorHasAnAntiresonance) {
  const double j = test_machines[paper].parameters.inertia;
  const DrivelineParameters<> p{0.5 * j, 0.5 * j * std::pow(2 * std::numbers::pi * 20, 2), 0.1};
  using Complex = std::complex<double>;
  for (const double hertz : {20.0, 20.0 * std::sqrt(1.5), 40.0}) {
    const int periods = int(std::lround(1e9 / (hertz * double(period_ns))));
    const double omega = 2 * std::numbers::pi / (periods * 1e-9 * double(period_ns));
    auto config = config_with(p, "[[0, 0]]", 4.0);
    config.scenario.torque_reference = {
        .shape = ProfileShape::sine, .amplitude = 10, .frequency_hz = omega / (2 * std::numbers::pi)};
    Stage stage{config.drive.plant, config.scenario.load};
    const auto controller = make_controller(config.drive);
    Drive<double> drive{config.drive.drive, *controller};
    ScenarioCommands commands{config.scenario};
    NoTelemetry none;
    Complex torque = 0, speed = 0;
    int n = 0;
    std::int64_t t_ns = -std::int64_t{ScenarioCommands::hand_shake_periods} * period_ns;
    for (; n < 10 * periods && t_ns < 10'000'000'000; t_ns += period_ns) {
      run_cycle(t_ns, stage.io(), commands, drive, none);
      if (t_ns < 3'000'000'000) continue;
      const Complex turned = std::polar(1.0, -2 * std::numbers::pi * n++ / periods);
      torque += stage.io().plant().tau_e() * turned;
      speed += stage.io().plant().omega_m() * turned;
    }
    const Complex s{0, omega};
    const Complex soft = p.damping * s + p.stiffness;
    const Complex scale = soft / (s * (j * p.inertia * s * s + (j + p.inertia) * soft));
    const Complex expected = scale * (p.inertia * s * s + soft) / soft;
    EXPECT_GT(std::abs(torque), 9.0 / 2 * n);
    EXPECT_LT(std::abs(speed / torque - expected), 0.02 * std::abs(scale)) << hertz;
    if (hertz == 20.0) {
      EXPECT_LT(std::abs(speed / torque), 0.05 * std::abs(scale));
    }
  }
}

// The shaft swings with 29 Hz, beyond the driver's 4 rad/s; after 6 s the vehicle rolls with up to 0.13 m/s.
// The speed of the motor, which rattles in the gap, is what the error is of.
TEST(DrivelineRun, ADriverFollowsTheSpeedOfTheVehicle) {
  for (const double backlash : {0.0, 0.02}) {
    ScenarioConfig config = load_scenario_config(
        SEXTANT_SOURCE_DIR "/configs/scenarios/paper/3_5_nycc_vehicle.toml",
        {"mode=sampled", "duration_s=12", "drive.period_us=100", "control.controller=foc",
         "drive.magnetise_first=true", "trace.interval_us=100000"});
    config.drive.plant.driveline = {0.5, 3000, 5, backlash};
    const MilResult result = run_behind(config);
    EXPECT_FALSE(result.faults.any());
    EXPECT_NEAR(result.metrics[Metric::load_speed_max], 0.13 / 0.2786, 0.05) << backlash;
    EXPECT_LT(result.metrics[Metric::speed_error_rms], 0.2) << backlash;
  }
}

TEST(DrivelineRun, ALoadOnTheMotorsShaftHasNoneOfItsEnergies) {
  const MilResult result = run(test_machines[paper], {.end_s = 0.2});
  for (const Metric m : {Metric::energy_friction, Metric::energy_damping, Metric::energy_load,
                         Metric::energy_kinetic, Metric::energy_elastic, Metric::shaft_torque_min,
                         Metric::shaft_torque_max, Metric::load_speed_min, Metric::load_speed_max})
    EXPECT_TRUE(std::isnan(result.metrics[m]));
}

}  // namespace
}  // namespace sextant
