#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include "ecu/parameters/parameter_changes.hpp"
#include "ecu/parameters/parameter_service.hpp"
#include "ecu/tasks/housekeeping_task.hpp"
#include "ecu/tasks/telemetry_task.hpp"
#include "ecu/telemetry/telemetry_sender.hpp"
#include "ecu/threads/control_thread.hpp"
#include "ecu/unit/drive_unit.hpp"
#include "ecu/unit/power_stage.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/config/ecu_config.hpp"

namespace sextant::ecu {

/// What the command line adds to the configuration of a live drive.
struct LiveDriveOptions {
  std::string record_cycles{};            ///< file for the control periods; empty for none
  std::string fault_socket{};             ///< as of PowerStage
  std::string set_socket{};               ///< local socket on which it takes parameters; empty for none
  ParameterChanges::Load load{};          ///< the configuration with further overrides; for `set_socket`
  std::string thread{"sextant-control"};  ///< name of the control thread, at most 15 characters
  std::string prefix{};  ///< of its lines in the log, where there are several drives: "drive 2: "
};

/// A drive of the live program: a DriveUnit with its power stage, control thread and the tasks for the
/// threads that the process runs.
class LiveDrive {
 public:
  /// Opens power stage and sockets. Throws std::runtime_error with one sentence where one cannot
  /// be opened. The bus must outlive this object.
  LiveDrive(const EcuConfig& config, CanBus& bus, const LiveDriveOptions& options);

  [[nodiscard]] DriveUnit& unit() noexcept { return unit_; }
  [[nodiscard]] const DriveUnit& unit() const noexcept { return unit_; }
  [[nodiscard]] HousekeepingTask& housekeeping() noexcept { return housekeeping_; }
  [[nodiscard]] TelemetryTask& telemetry() noexcept { return telemetry_; }
  /// Through which it sends its telemetry, for the process that publishes.
  [[nodiscard]] TelemetrySender& sender() noexcept { return sender_; }

  /// Starts the control thread, without a period. Throws where its rights are required and refused.
  void prepare();
  /// Starts the control periods; the telemetry begins here.
  void go();
  /// Ends the control thread and announces that to the plant.
  void join();
  /// Writes the control periods that wait for the recording; logs once where that fails.
  void write_cycles();
  /// Once no thread writes the recording: writes the rest of it.
  void close();

  /// Logs a change of a link, takes the fault and the parameters that wait; true where the run must end.
  [[nodiscard]] bool poll_link();

  /// Why the run ended early; empty where it did not.
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] const TimingStatistics& timing() const noexcept { return telemetry_.timing(); }
  // The report of the run, for people.
  void print_timing_and_commands(std::FILE* out) const;
  void print_telemetry(std::FILE* out, const CountsMessage& counts) const;

 private:
  void warn_of_unbounded_execution() const;
  void warn(const std::string& sentence) const;

  std::string prefix_;
  PowerStage power_stage_;
  DriveUnit unit_;
  std::optional<ParameterChanges> changes_{};
  std::optional<ParameterService> parameters_{};
  TelemetrySender sender_{};
  RightsReport rights_{};
  HousekeepingTask housekeeping_;
  TelemetryTask telemetry_;
  ControlThread control_;
};

}  // namespace sextant::ecu
