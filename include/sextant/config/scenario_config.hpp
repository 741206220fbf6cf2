#pragma once

#include <cstdint>
#include <optional>

#include "sextant/config/cycle_config.hpp"
#include "sextant/config/drive_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/event_exact/event_exact_runner.hpp"
#include "sextant/run/scenario.hpp"

namespace sextant {

/// How the comparators are run.
enum class ScenarioMode : std::uint8_t {
  sampled,     ///< the whole controller once per control period, as the live drive
  event_exact  ///< comparators and estimator in continuous time
};

/// A run of the simulated drive, as one file describes it.
struct ScenarioConfig {
  Scenario scenario{};  ///< its torque reference, load and expected fault are made of the members below
  ProfileParameters torque_nm{};  ///< [N·m]
  CycleConfig cycle{};            ///< where it is given, it takes the place of torque_nm and drive.load
  DriveConfig drive{};
  ScenarioMode mode{ScenarioMode::sampled};
  EventExactParameters event_exact{};
  std::optional<Fault> expected_fault{};
  TimeWindow expected_fault_window{};

  /// What an event-exact runner needs of it.
  [[nodiscard]] EventExactRunner::Parameters event_exact_runner() const;
};

void describe(Section root, ScenarioConfig& config);

}  // namespace sextant
