#pragma once

#include <cstdint>
#include <memory>

#include "sextant/control/controller.hpp"
#include "sextant/power_stage/faultable_drive_io.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario.hpp"

namespace sextant {

class TraceRecorder;

/// The power stage of a scenario whose drive takes its commands from a bus, as `LivePowerStage` with meter
/// and log, and what `MilRunner` finds of such a run: metrics, faults, torque that is missing.
///
/// Time zero of the scenario is at `begin_ns` of the drive's clock, which leaves the hand-shake its time.
/// Before it there is no load torque, so that the shaft stands; an imposed speed is there from the first
/// period on.
class ObservedPowerStage {
 public:
  using Parameters = SimulatedPowerStageParameters;

  /// Time zero of a scenario on the clock of a drive that starts at 0: the first control period 200 ms later
  /// or more. [ns]
  [[nodiscard]] static constexpr std::int64_t begin_ns(std::int64_t period_ns) noexcept {
    constexpr std::int64_t hand_shake_ns = 200'000'000;
    return (hand_shake_ns + period_ns - 1) / period_ns * period_ns;
  }

  /// Of the parameters the origin of the load is this class's. Throws as the power stages do, and
  /// std::runtime_error where a window of the scenario is none.
  ObservedPowerStage(const Scenario& scenario, const Parameters& parameters);
  ~ObservedPowerStage();

  [[nodiscard]] FaultableDriveIo& io() noexcept;

  /// Once, before the first control period: the controller whose comparators and channels are recorded, and
  /// the trace; both may be null and are not owned.
  void start(const Controller<>* controller, TraceRecorder* trace);

  /// What the scenario's vehicle commands at a time of the drive. [N·m]
  [[nodiscard]] double torque(std::int64_t t_ns);

  /// A control period that has run, on the drive's time, before the next read. Those after the end of the
  /// scenario are left out.
  void period(const Telemetry<double>& telemetry);

  /// True once the scenario has ended, or the plant has failed.
  [[nodiscard]] bool has_ended() const noexcept;

  /// Of the run so far, with the wall time since `start`. `stopped` is true where the scenario's end was not
  /// reached, and the plant has not failed.
  [[nodiscard]] MilResult result() const;

 private:
  class Impl;
  template <class Appended>
  class Stage;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sextant
