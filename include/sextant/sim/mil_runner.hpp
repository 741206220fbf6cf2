#pragma once

#include <cstdint>
#include <functional>

#include "sextant/drive/drive.hpp"
#include "sextant/sim/metric_list.hpp"
#include "sextant/sim/scenario.hpp"
#include "sextant/sim/simulated_drive_io.hpp"

namespace sextant {

class TraceRecorder;

/// How a run ended.
struct MilResult {
  MetricList metrics{};
  bool plant_healthy{true};  ///< false: the integrator failed, or its events did not end
  bool events_ended{true};   ///< false: an event-exact run had more events than it may
  DriveState final_state{DriveState::init};
  FaultSet faults{};        ///< latched during the run
  Fault first_fault{};      ///< meaningful while `faults.any()`
  std::int64_t fault_ns{};  ///< when it latched; before 0 in the hand-shake [ns]
};

/// Runs a scenario with the model in the loop, as fast as the machine allows: the same `run_cycle` as the
/// live drive, once a control period, on virtual time.
class MilRunner {
 public:
  /// Told now and then how far the run is, 0…1; false stops it.
  using Progress = std::function<bool(double fraction)>;

  /// Drive and power stage are not owned; both must be as after construction.
  MilRunner(Drive<double>& drive, SimulatedDriveIo<>& io, std::int32_t period_ns) noexcept
      : drive_{drive}, io_{io}, period_ns_{period_ns} {}

  /// Runs the whole scenario. `trace` may be null. Throws what the scenario's parts throw on bad parameters.
  [[nodiscard]] MilResult run(const Scenario& scenario, TraceRecorder* trace, const Progress& progress);

 private:
  Drive<double>& drive_;
  SimulatedDriveIo<>& io_;
  std::int32_t period_ns_;
};

}  // namespace sextant
