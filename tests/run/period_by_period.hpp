#pragma once

#include <cstdint>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {

/// The drive of a scenario on a power stage of that kind; calls look(t_s, telemetry, io) after each control
/// period. The plant stays healthy, and the drive makes torque at the end.
template <class Stage, class Look>
void go_through(const ScenarioConfig& config, Look look) {
  struct Newest {
    void push(const Telemetry<double>& t) noexcept SEXTANT_NONBLOCKING { telemetry = t; }
    Telemetry<double> telemetry{};
  };
  Stage stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  ScenarioCommands commands{config.scenario};
  Newest newest;
  const std::int64_t period_ns = config.drive.drive.period_ns;
  std::int64_t t_ns = -std::int64_t{ScenarioCommands::hand_shake_periods} * period_ns;
  for (; t_ns <= config.scenario.duration_ns; t_ns += period_ns) {
    run_cycle(t_ns, stage.io(), commands, drive, newest);
    ASSERT_TRUE(stage.io().healthy());
    look(double(t_ns) * 1e-9, newest.telemetry, stage.io());
  }
  EXPECT_TRUE(makes_torque(drive.state())) << to_string(newest.telemetry.first_fault);
}

}  // namespace sextant
