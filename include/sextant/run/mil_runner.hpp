#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <optional>
#include <variant>
#include <vector>

#include "sextant/control/controller.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/cycle_following.hpp"
#include "sextant/run/metric_list.hpp"
#include "sextant/run/scenario.hpp"
#include "sextant/run/torque_answer.hpp"

namespace sextant {

class TraceRecorder;

/// A fault of a run, and when it latched.
struct LatchedFault {
  Fault fault{};
  std::int64_t t_ns{};  ///< before 0 in the hand-shake [ns]
};

/// How a run ended.
struct MilResult {
  MetricList metrics{};
  std::vector<MetricList> window_metrics{};       ///< of each of the scenario's windows
  bool plant_healthy{true};                       ///< false: the integration failed, or one of the two below
  bool plant_reachable{true};                     ///< false: the plant's state has left its equations
  bool events_ended{true};                        ///< false: an event-exact run had more events than it may
  bool stopped{false};                            ///< the caller has ended the run early
  std::optional<MissingTorque> missing_torque{};  ///< asked and not made, of a sampled run
  std::optional<CycleDeparture> cycle_departure{};  ///< of a driver that did not follow
  DriveState final_state{DriveState::init};
  FaultSet faults{};                        ///< latched during the run
  Fault first_fault{};                      ///< meaningful while `faults.any()`
  std::int64_t fault_ns{};                  ///< when it latched; before 0 in the hand-shake [ns]
  std::vector<LatchedFault> fault_times{};  ///< every one of `faults`, in the order in which they latched

  /// Takes what is latched at t_ns; `first`: the one that came first.
  void note_faults(FaultSet latched, Fault first, std::int64_t t_ns);
};

/// Runs a scenario with the model in the loop, as fast as the machine allows: the same `run_cycle` as the
/// live drive, once a control period, on virtual time.
class MilRunner {
 public:
  /// Called several times a second with the progress of the run, 0…1; false stops it.
  using Progress = std::function<bool(double fraction)>;

  /// Of a power stage of `MeteredPowerStageOf`.
  template <class Appended>
  using Io = typename MeteredPowerStageOf<Appended>::Io;
  using AnyIo = std::variant<Io<NoAppendedSystem<double>>*, Io<DcLink<double>>*, Io<Driveline<double>>*,
                             Io<LinkAndDriveline>*>;

  /// Drive and power stage are not owned; both must be as after construction. `controller`: the drive's,
  /// whose comparators and channels are recorded; may be null.
  template <class SomeIo>
    requires std::constructible_from<AnyIo, SomeIo*>
  MilRunner(Drive<double>& drive, SomeIo& io, std::int32_t period_ns,
            const Controller<>* controller = nullptr) noexcept
      : drive_{drive}, io_{&io}, period_ns_{period_ns}, controller_{controller} {}

  /// Runs the whole scenario. `trace` may be null. Throws what the scenario's parts throw on bad parameters.
  [[nodiscard]] MilResult run(const Scenario& scenario, TraceRecorder* trace, const Progress& progress);

 private:
  template <class SomeIo>
  MilResult run(SomeIo& io, const Scenario& scenario, TraceRecorder* trace, const Progress& progress);

  Drive<double>& drive_;
  AnyIo io_;
  std::int32_t period_ns_;
  const Controller<>* controller_;
};

}  // namespace sextant
