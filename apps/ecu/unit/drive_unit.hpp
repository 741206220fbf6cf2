#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "ecu/shared/shared_state.hpp"
#include "ecu/tasks/control_task.hpp"
#include "ecu/tasks/receive_task.hpp"
#include "ecu/tasks/transmit_task.hpp"
#include "ecu/tasks/watchdog_task.hpp"
#include "ecu/unit/configured_drive.hpp"
#include "ecu/unit/cycle_log.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/core/drive_io.hpp"

namespace sextant::ecu {

/// One drive without a process: its configuration, the drive, the shared state and the tasks that work on it.
/// A process runs the tasks on threads, virtual time runs them on a timeline.
class DriveUnit {
 public:
  /// Power stage and bus are not owned and must outlive this object. `inhibit_gates` clears the gate-enable
  /// line of a link. record_cycles: file for the control periods; empty for none.
  DriveUnit(
      const EcuConfig& config, DriveIo<double>& io, CanBus& bus, std::function<void()> inhibit_gates = [] {},
      const std::string& record_cycles = {})
      : config_{config},
        io_{io},
        drive_{config.drive},
        shared_{config.drive.drive.period_ns, config.realtime.wake_every_periods,
                config.realtime.watchdog_ns},
        control_{{.period_ns = config.drive.drive.period_ns,
                  .wake_every_periods = config.realtime.wake_every_periods},
                 drive_.drive(),
                 shared_,
                 config.realtime.overrun_limit},
        receive_{shared_, config.can.identifier_offset},
        transmit_{bus, shared_, config.can.identifier_offset},
        watchdog_{shared_, std::move(inhibit_gates)} {
    if (!record_cycles.empty()) cycles_.emplace(record_cycles, config);
  }
  DriveUnit(const DriveUnit&) = delete;
  DriveUnit& operator=(const DriveUnit&) = delete;

  [[nodiscard]] const EcuConfig& config() const noexcept { return config_; }
  [[nodiscard]] const Controller<double>& controller() const noexcept { return drive_.controller(); }
  [[nodiscard]] DriveIo<double>& io() noexcept { return io_; }
  [[nodiscard]] SharedState& shared() noexcept { return shared_; }
  [[nodiscard]] const SharedState& shared() const noexcept { return shared_; }
  [[nodiscard]] ControlTask& control() noexcept { return control_; }
  [[nodiscard]] const ControlTask& control() const noexcept { return control_; }
  [[nodiscard]] ReceiveTask& receive() noexcept { return receive_; }
  [[nodiscard]] const ReceiveTask& receive() const noexcept { return receive_; }
  [[nodiscard]] TransmitTask& transmit() noexcept { return transmit_; }
  [[nodiscard]] const TransmitTask& transmit() const noexcept { return transmit_; }
  [[nodiscard]] WatchdogTask& watchdog() noexcept { return watchdog_; }

  /// The recording of the control periods; nullptr for none.
  [[nodiscard]] CycleLog* cycles() noexcept { return cycles_ ? &*cycles_ : nullptr; }
  [[nodiscard]] const CycleLog* cycles() const noexcept { return cycles_ ? &*cycles_ : nullptr; }
  /// What the probe of the periods feeds; nullptr for none.
  [[nodiscard]] CycleRecorder* recorder() noexcept { return cycles_ ? &cycles_->recorder() : nullptr; }

  /// Torque to zero, gates off, stop; from any thread.
  void shut_down() noexcept { shared_.shutdown.store(true, std::memory_order_release); }

 private:
  EcuConfig config_;
  DriveIo<double>& io_;
  ConfiguredDrive drive_;
  SharedState shared_;
  ControlTask control_;
  ReceiveTask receive_;
  TransmitTask transmit_;
  WatchdogTask watchdog_;
  std::optional<CycleLog> cycles_{};
};

}  // namespace sextant::ecu
