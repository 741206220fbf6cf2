#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sextant/power_stage/mechanical_load.hpp"
#include "sextant/profiles/driver.hpp"
#include "sextant/profiles/profile.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "sextant/run/expectation.hpp"
#include "sextant/run/metrics.hpp"

namespace sextant {

/// A vehicle whose driver follows a speed by torque commands.
struct DrivenCycle {
  ProfileParameters speed{};  ///< of the vehicle, as it shall be [m/s]
  Driver::Parameters driver{};
};

/// What happens in a run, and what is expected of it; drive and plant are described apart.
struct Scenario {
  std::string name{};
  std::string description{};
  std::int64_t duration_ns{1'000'000'000};  ///< [ns]
  ProfileParameters torque_reference{};     ///< [N·m]
  std::optional<DrivenCycle> cycle{};       ///< its driver gives the torque reference instead
  MechanicalLoad::Parameters load{};
  MetricsParameters metrics{};
  TraceParameters trace{};
  std::vector<Expectation> expectations{};
  std::vector<WindowExpectation> windows{};          ///< limits over parts of the run
  std::optional<FaultExpectation> expected_fault{};  ///< empty: a trip is no success
};

}  // namespace sextant
