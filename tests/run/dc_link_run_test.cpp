// A drive on a DC link whose voltage is a state, against closed forms of power electronics: the quadratic
// equation of a source that delivers a power, the times of a brake chopper under a constant power, the RMS
// current of the capacitor under a modulated pattern.

#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "run/period_by_period.hpp"

namespace sextant {
namespace {

using Stage = LinkedMeteredPowerStage;
using Link = DcLink<>;

constexpr int paper = 1;

ScenarioConfig config_with(const DcLinkParameters<>& link, double omega_m, const std::string& torque,
                           double end_s) {
  ScenarioConfig config = machine_config(
      test_machines[paper],
      {.controller = "foc", .period_us = 50, .omega_m = omega_m, .end_s = end_s, .torque = torque});
  config.drive.plant.link = link;
  config.drive.plant.integrator = IntegratorKind::fixed;
  return config;
}

MilResult run_linked(const ScenarioConfig& config) {
  Stage stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  return MilRunner{drive, stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
}

const Link& link_of(const Stage::Plant& plant) {
  return plant.appended_system().first;
}

/// Drawn by the inverter. [J]
double drawn(const Stage::Plant& plant) {
  return plant.state()[Stage::Plant::appended + Link::size + int(EnergyMeter<>::dc_link)];
}

// u² − u_0 u + P R = 0, before and after a step of the torque at speed.
TEST(DcLinkRun, VoltageSagsToTheRootOfTheSourcesEquation) {
  constexpr double u_0 = 530, r = 1.0, omega_m = 100;
  const auto config = config_with({2e-3, r}, omega_m, "[[0, 0], [0.4, 20], [0.8, 60], [1.2, -60]]", 1.6);
  struct Window {
    double from_s, to_s, begin_j{}, end_j{}, sum{};
    int count{};
  };
  std::vector<Window> windows{{0.6, 0.8}, {1.0, 1.2}, {1.4, 1.6}};
  go_through<Stage>(config, [&](double t, const Telemetry<double>&, const Stage::Io& io) {
    for (Window& w : windows) {
      if (t < w.from_s - 1e-9 || t > w.to_s - 1e-9) continue;
      if (w.count++ == 0) w.begin_j = drawn(io.plant());
      w.end_j = drawn(io.plant());
      w.sum += io.plant().u_dc();
    }
  });
  for (const Window& w : windows) {
    const double power = (w.end_j - w.begin_j) / (double(w.count - 1) * 50e-6);
    const double expected = u_0 / 2 + std::sqrt(u_0 * u_0 / 4 - power * r);
    EXPECT_GT(std::abs(power), 1000);
    EXPECT_NEAR(w.sum / w.count, expected, 0.02 + 0.01 * std::abs(expected - u_0));
  }
}

// A rectifier takes nothing back: the braking machine charges the capacitor to the chopper's upper voltage in
// C (U_1² − U_2²)/2P, and the chopper discharges it in R_b C/2 ln((U_1² − P R_b)/(U_2² − P R_b)).
TEST(DcLinkRun, TheChopperHoldsTheLinkWhileTheMachineBrakes) {
  constexpr double c = 1e-3, r_b = 25, on = 640, off = 600;
  const auto config = config_with({c, 0.2, 0, true, r_b, on, off}, 100, "[[0, 0], [0.4, -60]]", 1.2);
  int turn_ons = 0;
  bool was_on = false;
  double first = 0, last = 0, first_j = 0, last_j = 0, lowest = 1e9, highest = 0;
  go_through<Stage>(config, [&](double t, const Telemetry<double>&, const Stage::Io& io) {
    const bool is_on = link_of(io.plant()).chops();
    const double u = io.plant().u_dc();
    highest = std::max(highest, u);
    if (turn_ons > 0) lowest = std::min(lowest, u);
    if (is_on && !was_on && t > 0.6) {
      last = t;
      last_j = drawn(io.plant());
      if (turn_ons++ == 0) {
        first = t;
        first_j = last_j;
      }
    }
    was_on = is_on;
  });
  ASSERT_GT(turn_ons, 5);
  const double power = -(last_j - first_j) / (last - first);
  EXPECT_GT(power, 3000);
  const double rise_s = c * (on * on - off * off) / (2 * power);
  const double fall_s = r_b * c / 2 * std::log((on * on - power * r_b) / (off * off - power * r_b));
  EXPECT_NEAR((last - first) / (turn_ons - 1), rise_s + fall_s, 0.01 * (rise_s + fall_s));
  // A control period's charge beyond, at the largest.
  EXPECT_LT(highest, on + 2);
  EXPECT_GT(lowest, off - 2);
}

// Source, capacitor, chopper and machine over motoring, braking and gates off, with dead time and drops.
TEST(DcLinkRun, EnergyClosesOverTheRun) {
  for (const IntegratorKind integrator : {IntegratorKind::fixed, IntegratorKind::erk}) {
    auto config =
        config_with({1e-3, 0.2, 1e-4, true, 25, 640, 600}, 100, "[[0, 0], [0.3, 40], [0.5, -60]]", 0.7);
    config.drive.plant.integrator = integrator;
    config.drive.plant.io.dead_time_ns = 2'000;
    config.drive.plant.plant.drops = {1.2, 0.02};
    config.scenario.metrics.from_ns = 0;
    const MetricList m = run_linked(config).metrics;
    EXPECT_LT(m[Metric::energy_unaccounted], 1e-5);
    EXPECT_GT(m[Metric::energy_source], 100);
    EXPECT_GT(m[Metric::energy_chopper], 100);
    EXPECT_GT(m[Metric::energy_source_loss], 0.1);
    EXPECT_GT(m[Metric::energy_stored], 1.0);
    const double drawn = m[Metric::energy_from_link] - m[Metric::energy_to_link];
    const double passed = m[Metric::energy_source] - m[Metric::energy_source_loss] -
                          m[Metric::energy_chopper] - m[Metric::energy_stored];
    EXPECT_NEAR(drawn, passed, 1e-5 * m[Metric::energy_source]);
  }
}

TEST(DcLinkRun, AStiffLinkHasNoEnergiesBeforeIt) {
  const MilResult result = run(test_machines[paper], {.end_s = 0.2});
  for (const Metric m :
       {Metric::energy_source, Metric::energy_source_loss, Metric::energy_chopper, Metric::energy_stored})
    EXPECT_TRUE(std::isnan(result.metrics[m]));
}

// I_C² = I² 2M (√3/4π + cos²φ (√3/π − 9M/16)): RMS current of the capacitor of an inverter with symmetrical
// modulation and sinusoidal currents of RMS value I, M the phase voltage by u/2. Source: J. W. Kolar,
// S. D. Round, "Analytical calculation of the RMS current stress on the DC-link capacitor of voltage-PWM
// converter systems", IEE Proc. Electr. Power Appl. 153 (2006) 535–543. The source's inductance keeps its
// current smooth.
TEST(DcLinkRun, TheCapacitorCarriesTheRippleOfAModulatedPattern) {
  constexpr double c = 1e-3;
  const auto config = config_with({c, 1.0, 5e-3}, 100, "[[0, 0], [0.4, 60]]", 1.2);
  double seconds = 0, charge_squared = 0, u = 0, i_squared = 0, p_s = 0, q_s = 0;
  SpaceVector<> flux_before{};
  double flux_volts = 0;
  int periods = 0;
  go_through<Stage>(config, [&](double t, const Telemetry<double>&, const Stage::Io& io) {
    const Stage::Plant& plant = io.plant();
    const SpaceVector<> psi_s = plant.psi_s();
    if (t > 0.8) {
      const auto instants = io.log().instants();
      for (const ActedSegment& segment : io.log().segments()) {
        const double h = double(segment.duration_ns) * 1e-9;
        const double rise =
            instants[segment.end][Stage::Plant::appended] - instants[segment.begin][Stage::Plant::appended];
        charge_squared += (c * rise) * (c * rise) / h;
        seconds += h;
      }
      // The fundamental: mean voltage of the period by flux and resistance, current at its end.
      const double r_s = plant.machine().parameters().r_s;
      const SpaceVector<> u_mean = 1 / 50e-6 * (psi_s - flux_before) + r_s * plant.i_s();
      flux_volts += magnitude(u_mean);
      p_s += dot(u_mean, plant.i_s());
      q_s += cross(u_mean, plant.i_s());
      i_squared += dot(plant.i_s(), plant.i_s()) / 2;
      u += plant.u_dc();
      ++periods;
    }
    flux_before = psi_s;
  });
  const double m = flux_volts / periods / (0.5 * u / periods);
  const double cos_phi = p_s / std::hypot(p_s, q_s);
  constexpr double root3 = std::numbers::sqrt3, pi = std::numbers::pi;
  const double share = 2 * m * (root3 / (4 * pi) + cos_phi * cos_phi * (root3 / pi - 9 * m / 16));
  const double expected = std::sqrt(i_squared / periods * share);
  EXPECT_GT(expected, 3);
  EXPECT_NEAR(std::sqrt(charge_squared / seconds), expected, 0.03 * expected) << "M " << m;
}

// The link falls at its source, and the capacitor follows by R C.
TEST(DcLinkRun, ASagOfTheSourceReachesTheLinkThroughItsResistance) {
  auto config = config_with({1e-3, 5.0}, 0, "[[0, 0]]", 0.5);
  config.drive.plant.io.fault = {.kind = PlantFaultKind::link_sag, .at_ns = 450'000'000, .sag_voltage = 400};
  double worst = 0;
  double before = 0;
  go_through<Stage>(config, [&](double t, const Telemetry<double>&, const Stage::Io& io) {
    if (t < 0.45 + 1e-9) {
      before = io.plant().u_dc();
    } else {
      // The magnetising current takes some watts from both.
      const double expected = 400 + (before - 400) * std::exp(-(t - 0.45) / 5e-3);
      worst = std::max(worst, std::abs(io.plant().u_dc() - expected));
    }
  });
  EXPECT_LT(worst, 2.5);
}

}  // namespace
}  // namespace sextant
