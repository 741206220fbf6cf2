#pragma once

#include <vector>

#include "support/recorded_drive.hpp"

namespace sextant::bench {

/// Measurements and patterns of a settled drive at 15 N·m and 50 rad/s, one control period each: the inputs
/// that every contestant gets.
struct RecordedRun {
  std::vector<Measurement<double>> measurements{};
  std::vector<GatePattern> patterns{};  ///< decided on the measurement of the same index
  DrivePlant<double>::State begin{};    ///< the plant's state at the first measurement
};

/// Few enough to stay in the first-level cache, as a live drive's single measurement does.
inline constexpr int recorded_periods = 192;

inline constexpr double torque_reference = 15.0;  // [N·m]

/// With a controller of that class.
template <class C = DirectTorqueController<double>>
RecordedRun record_run() {
  MechanicalLoad::Parameters load;
  load.imposed_speed = ProfileParameters{.value = 50.0};
  testing::RecordedDrive<C> drive{load, {.value = torque_reference}};
  RecordedRun run;
  constexpr std::int64_t settled = 8'000;
  drive.run(settled + recorded_periods,
            [&](std::int64_t k, const Measurement<double>& measurement, const GatePattern& pattern) {
              if (k < settled) return;
              if (k == settled) run.begin = drive.plant().state();
              run.measurements.push_back(measurement);
              run.patterns.push_back(pattern);
            });
  return run;
}

}  // namespace sextant::bench
