#pragma once

#include <cstdint>
#include <vector>

#include "support/recorded_drive.hpp"

namespace sextant::testing {

inline constexpr std::int64_t recorded_period_ns = RecordedDrive<>::period_ns;

/// The gate patterns of a drive as it magnetises a machine at rest, accelerates it with 20 N·m, brakes it
/// with −20 N·m and accelerates it again, a switching state for each period of 25 µs: one sequence that every
/// integrator can be given. The load torque is 2 N·m.
inline std::vector<SwitchState> record_switching(double duration_s) {
  MechanicalLoad::Parameters load;
  load.load_torque = ProfileParameters{.value = 2.0};
  RecordedDrive<> drive{load,
                        {.shape = ProfileShape::steps,
                         .points = {{0.0, 20.0}, {0.45 * duration_s, -20.0}, {0.7 * duration_s, 20.0}}}};
  std::vector<SwitchState> sequence;
  drive.run(std::int64_t(duration_s * 1e9) / recorded_period_ns,
            [&](std::int64_t, const Measurement<double>&, const GatePattern& pattern) {
              sequence.push_back(pattern.last_state());
            });
  return sequence;
}

}  // namespace sextant::testing
