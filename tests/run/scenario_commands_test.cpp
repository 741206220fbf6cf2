#include "sextant/run/scenario_commands.hpp"

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/run/scenario_mark.hpp"

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 25'000;
constexpr int hand_shake = ScenarioCommands::hand_shake_periods;

TEST(ScenarioCommands, DisablesFirstThenEnablesWithoutTorque) {
  ScenarioCommands commands{ProfileParameters{.value = 15.0}};
  for (std::int64_t k = -hand_shake; k < 0; ++k) {
    const TorqueCommand<> c = commands.latest(k * period_ns).command;
    EXPECT_EQ(c.enable, k == -1) << "period " << k;
    EXPECT_EQ(c.torque, 0.0);
    EXPECT_EQ(c.e2e, E2eState::valid);
    EXPECT_EQ(c.received_ns, k * period_ns);
    EXPECT_EQ(c.sequence, std::uint32_t(k + hand_shake + 1)) << "every period brings a new command";
  }
  EXPECT_EQ(commands.latest(0).command.torque, 15.0);
}

TEST(ScenarioCommands, PlaysTheProfile) {
  ScenarioCommands commands{{.shape = ProfileShape::steps, .points = {{0.0, 15.0}, {0.4, -15.0}}}};
  EXPECT_EQ(commands.reference(-1), 0.0);
  EXPECT_EQ(commands.reference(399'999'999), 15.0);
  EXPECT_EQ(commands.reference(400'000'000), -15.0);
  EXPECT_EQ(commands.latest(400'000'000).command.torque, -15.0);
}

TEST(ScenarioMark, IsThatOfTorqueAndDuration) {
  Scenario scenario;
  scenario.torque_reference = {.shape = ProfileShape::steps, .points = {{0.0, 15.0}, {0.4, -15.0}}};
  const std::uint32_t mark = scenario_mark(scenario);
  Scenario same = scenario;
  same.name = "other";
  same.load.load_torque.value = 3.0;
  EXPECT_EQ(scenario_mark(same), mark) << "drives that play both do the same";
  Scenario other = scenario;
  other.duration_ns += 1;
  EXPECT_NE(scenario_mark(other), mark);
  other = scenario;
  other.torque_reference.shape = ProfileShape::linear;
  EXPECT_NE(scenario_mark(other), mark);
  other = scenario;
  other.torque_reference.points[1].value = -14.999;
  EXPECT_NE(scenario_mark(other), mark);
  other = scenario;
  other.torque_reference.points.swap(other.torque_reference.table);
  EXPECT_NE(scenario_mark(other), mark);
}

TEST(ScenarioCommands, ADriverSeesTheMeasuredSpeedAndHoldsItsTorque) {
  Scenario scenario;
  scenario.torque_reference.value = 99.0;
  scenario.cycle = DrivenCycle{{.shape = ProfileShape::linear, .points = {{0.0, 2.0}, {1.0, 3.0}}}, {}};
  const Driver::Parameters& p = scenario.cycle->driver;
  ScenarioCommands commands{scenario};
  for (std::int64_t k = -hand_shake; k < 0; ++k)
    EXPECT_EQ(commands.latest(k * period_ns).command.torque, 0.0);
  commands.note_speed(6.0);
  const double expected = p.mass * p.wheel_radius / p.motors * p.bandwidth * (2.0 - 6.0 * p.wheel_radius);
  EXPECT_NEAR(commands.latest(0).command.torque, expected, 1e-12);
  EXPECT_NEAR(commands.reference(0), expected, 1e-12);
  commands.note_speed(50.0);
  for (std::int64_t t = period_ns; t < p.period_ns; t += period_ns)
    ASSERT_NEAR(commands.latest(t).command.torque, expected, 1e-12);
  EXPECT_LT(commands.latest(p.period_ns).command.torque, 0.0) << "too fast: it brakes";
  EXPECT_NEAR(commands.speed_reference(500'000'000), 2.5 / p.wheel_radius, 1e-12);
  EXPECT_TRUE(std::isnan(ScenarioCommands{ProfileParameters{}}.speed_reference(0)));
}

TEST(ScenarioCommands, TheHandShakeBringsADriveToTorqueAtTimeZero) {
  ScenarioCommands commands{ProfileParameters{.value = 15.0}};
  DirectTorqueController<double> controller{{}};
  Drive<double> drive{{.magnetise_first = false}, controller};
  const auto step = [&](std::int64_t k) {
    const Measurement<double> m{.u_dc = 530.0, .applied = {gates_off, period_ns}};
    return drive.step(k * period_ns, m, commands.latest(k * period_ns));
  };
  for (std::int64_t k = -hand_shake; k < 0; ++k) EXPECT_EQ(step(k).telemetry.torque_reference, 0.0);
  const DriveOutput<double> first = step(0);
  EXPECT_EQ(first.telemetry.state, DriveState::torque);
  EXPECT_EQ(first.telemetry.torque_reference, 15.0);
  EXPECT_TRUE(is_driven(first.pattern.last_state()));
}

}  // namespace
}  // namespace sextant
