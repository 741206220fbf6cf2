// Runs of a controller that switches several times a period: their metrics are those of the plant itself.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::int32_t period_ns = 100'000;
constexpr double frequency_hz = 30;
constexpr double speed = 2 * pi * frequency_hz / 2 * 0.98;  // two pole pairs, 2 % slip
constexpr std::int64_t begin_ns = 800'000'000;
constexpr std::int64_t end_ns = 1'000'000'000;

/// Symmetric space-vector modulation of a voltage that turns at a constant frequency: seven segments a
/// period.
GatePattern space_vector_pattern(std::int64_t period) {
  constexpr double depth = 0.4;  // of u_dc
  const double theta = 2 * pi * frequency_hz * double(period * period_ns) * 1e-9;
  std::array<double, 3> duty{};
  for (int x = 0; x < 3; ++x) duty[std::size_t(x)] = depth * std::cos(theta - 2 * pi / 3 * x);
  const auto [least, most] = std::minmax_element(duty.begin(), duty.end());
  const double offset = 0.5 - 0.5 * (*least + *most);
  // Leg x is high for its share of the period, about the middle of it.
  std::vector<std::int64_t> edges{0, period_ns};
  std::array<std::int64_t, 3> on{}, off{};
  for (std::size_t x = 0; x < 3; ++x) {
    const double share = duty[x] + offset;
    on[x] = std::llround((1 - share) / 2 * period_ns);
    off[x] = period_ns - on[x];
    edges.insert(edges.end(), {on[x], off[x]});
  }
  std::sort(edges.begin(), edges.end());
  GatePattern pattern;
  for (std::size_t k = 1; k < edges.size(); ++k) {
    const auto leg = [&](std::size_t x) {
      return edges[k - 1] >= on[x] && edges[k - 1] < off[x] ? LegState::high : LegState::low;
    };
    pattern.append({{leg(0), leg(1), leg(2)}, std::int32_t(edges[k] - edges[k - 1])});
  }
  return pattern;
}

class SpaceVectorController final : public Controller<double> {
 public:
  GatePattern step(const Measurement<double>&, ControlReference<double> reference) noexcept override {
    estimate_.magnetised = true;
    const std::int64_t period = period_++;
    return reference.mode == ControlMode::torque ? space_vector_pattern(period) : GatePattern{};
  }
  void reset() noexcept override {}

 private:
  std::int64_t period_{
      -std::int64_t{ScenarioCommands::hand_shake_periods}};  ///< 0 at the time zero of the run
};

/// The same patterns on a plant of its own, looked at every microsecond and counted by hand.
struct Truth {
  double torque_pp{}, torque_rms{}, thd{}, switching_hz{};
};
Truth truth(const DrivePlantParameters<>& parameters) {
  DrivePlant<double> plant{parameters};
  FixedStepIntegrator<DrivePlant<double>> integrator;
  plant.set_speed(speed);
  double least = 1e9, most = -1e9, sum = 0, squares = 0, current_squares = 0;
  SpaceVector<> current{};
  std::int64_t n = 0, turn_ons = 0, t = 0;
  SwitchState before{};
  for (std::int64_t period = 0; t < end_ns; ++period) {
    const GatePattern pattern = space_vector_pattern(period);
    for (const GateSegment& segment : pattern.segments()) {
      plant.set_inputs({segment.state, 530, 0, true, 0});
      const unsigned on = segment.state.upper_switches() & ~before.upper_switches();
      if (t > begin_ns) turn_ons += (on & 1U) + (on >> 1U & 1U) + (on >> 2U);
      before = segment.state;
      for (std::int64_t left = segment.duration_ns; left > 0;) {
        const std::int64_t h = std::min<std::int64_t>(left, 1'000);
        EXPECT_TRUE(integrator.advance(plant, h));
        left -= h;
        t += h;
        if (t <= begin_ns) continue;
        const double torque = plant.tau_e();
        const SpaceVector<> axis = (1 / magnitude(plant.psi_s())) * plant.psi_s();
        const SpaceVector<> i{dot(axis, plant.i_s()), cross(axis, plant.i_s())};
        least = std::min(least, torque);
        most = std::max(most, torque);
        sum += torque * double(h);
        squares += torque * torque * double(h);
        current += double(h) * i;
        current_squares += dot(i, i) * double(h);
        n += h;
      }
    }
  }
  const double weight = double(n);
  const SpaceVector<> mean = (1 / weight) * current;
  return {.torque_pp = most - least,
          .torque_rms = std::sqrt(squares / weight - sum * sum / weight / weight),
          .thd = 100 * std::sqrt(current_squares / weight - dot(mean, mean)) / magnitude(mean),
          .switching_hz = double(turn_ons) / 3 / (double(end_ns - begin_ns) * 1e-9)};
}

TEST(MultiSegmentRun, MetricsFollowEverySegment) {
  RigParameters p = RigParameters::at_speed(speed, IntegratorKind::fixed);
  p.stage.io.period_ns = period_ns;
  p.drive.period_ns = period_ns;
  p.drive.protection.over_current = 1e4;
  p.drive.torque_monitor.enabled = false;  // these patterns follow no torque reference
  MeteredPowerStage stage{p.stage, p.load};
  SpaceVectorController controller;
  Drive<double> drive{p.drive, controller};
  Scenario scenario;
  scenario.name = "space vectors";
  scenario.duration_ns = end_ns;
  scenario.torque_reference.value = 10;
  scenario.metrics = {.from_ns = begin_ns, .to_ns = end_ns};
  const MilResult result = MilRunner{drive, stage.io(), period_ns}.run(scenario, nullptr, {});
  ASSERT_FALSE(result.faults.any());

  const Truth expected = truth(p.stage.plant);
  EXPECT_NEAR(expected.switching_hz, 1e4, 10);
  EXPECT_GT(expected.torque_pp, 0.5);
  const MetricList& m = result.metrics;
  EXPECT_NEAR(m[Metric::switching_frequency], expected.switching_hz, 10);
  EXPECT_NEAR(m[Metric::torque_ripple_pp], expected.torque_pp, 0.02 * expected.torque_pp);
  EXPECT_NEAR(m[Metric::torque_ripple_rms], expected.torque_rms, 0.02 * expected.torque_rms);
  EXPECT_NEAR(m[Metric::current_thd], expected.thd, 0.02 * expected.thd);
  EXPECT_LT(m[Metric::energy_unaccounted], 1e-4);
  EXPECT_TRUE(std::isnan(m[Metric::torque_pulse_frequency])) << "this controller has no torque comparator";
}

}  // namespace
}  // namespace sextant
