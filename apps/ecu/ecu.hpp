#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "ecu/configured_drive.hpp"
#include "ecu/parameters/parameter_changes.hpp"
#include "ecu/parameters/parameter_service.hpp"
#include "ecu/power_stage.hpp"
#include "ecu/replay/cycle_log.hpp"
#include "ecu/replay/cycle_thread.hpp"
#include "ecu/shared_state.hpp"
#include "ecu/telemetry/telemetry_process.hpp"
#include "ecu/threads/control_thread.hpp"
#include "ecu/threads/housekeeping_thread.hpp"
#include "ecu/threads/link_thread.hpp"
#include "ecu/threads/receive_thread.hpp"
#include "ecu/threads/telemetry_thread.hpp"
#include "ecu/threads/transmit_thread.hpp"
#include "ecu/threads/watchdog_thread.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/realtime/processor_latency.hpp"

namespace sextant::ecu {

/// The live drive: the drive with its power stage, CAN and DDS, and its threads with their shared state. The
/// threads and the process for DDS run on the CPUs of the caller; see keep_off_cpu().
class Ecu {
 public:
  /// Opens power stage, bus and publisher. Throws std::runtime_error with one sentence where one cannot be
  /// opened.
  /// record_cycles: file for the control periods; empty for none. fault_socket: as of PowerStage.
  explicit Ecu(const EcuConfig& config, const std::string& record_cycles = {},
               const std::string& fault_socket = {});
  ~Ecu();

  /// Takes parameters on this local socket while the drive runs; before the start. Throws as RequestSocket.
  void serve_parameters(const std::string& socket, ParameterChanges::Load load);

  /// Starts the threads. Throws when real-time rights are required and refused.
  void start();

  /// Torque to zero, gates off, threads joined. Safe to call twice.
  void stop();

  /// Why the run ended early; empty where it did not.
  [[nodiscard]] std::string problem() const;

  /// The timing of the run, for programs. Throws std::runtime_error where the file cannot be written.
  void write_timing(const std::string& file) const;

  /// The report of the run, for people.
  void print_report(std::FILE* out) const;

 private:
  /// Receives for a while before the first frame is sent. Throws where another drive is on the bus.
  void require_lone_drive();
  void warn_of_unbounded_execution() const;
  /// The power stage, with the recorder before it where the control periods are recorded.
  [[nodiscard]] DriveIo<double>& recorded_io(const std::string& record_cycles);
  void print_dds(std::FILE* out) const;

  EcuConfig config_;
  ProcessorLatency processor_latency_;
  SharedState shared_;
  PowerStage power_stage_;
  std::optional<CycleLog> cycles_{};
  std::optional<CycleThread> cycle_thread_{};
  ConfiguredDrive drive_;
  std::optional<ParameterChanges> changes_{};
  std::optional<ParameterService> parameters_{};
  std::unique_ptr<CanBus> bus_;
  TelemetryProcess publisher_;
  ControlThread control_;
  ReceiveThread receive_;
  TransmitThread transmit_;
  WatchdogThread watchdog_;
  LinkThread link_;
  HousekeepingThread housekeeping_;
  TelemetryThread telemetry_;
};

}  // namespace sextant::ecu
