#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "ecu/can_receive_thread.hpp"
#include "ecu/can_transmit_thread.hpp"
#include "ecu/control_thread.hpp"
#include "ecu/crossings.hpp"
#include "ecu/housekeeping_thread.hpp"
#include "ecu/power_stage.hpp"
#include "ecu/power_stage_monitor.hpp"
#include "ecu/telemetry_process.hpp"
#include "ecu/telemetry_thread.hpp"
#include "ecu/watchdog_thread.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/realtime/processor_latency.hpp"

namespace sextant::ecu {

/// The live drive: control core, power stage, CAN and DDS, and the threads that join them.
class Ecu {
 public:
  /// Opens everything. Throws std::runtime_error with one sentence where something cannot be had.
  explicit Ecu(const EcuConfig& config);
  ~Ecu();

  /// Starts the threads. Throws when real-time rights are required and refused.
  void start();

  /// Torque to zero, gates off, threads joined. Safe to call twice.
  void stop();

  /// Why it could not go on; empty where it could.
  [[nodiscard]] std::string problem() const { return power_stage_.problem(); }

  /// The timing of the run, for programs. Throws std::runtime_error where the file cannot be written.
  void write_timing(const std::string& file) const;

  /// What happened, for people.
  void print_report(std::FILE* out) const;

 private:
  /// Listens before it speaks. Throws where another drive is heard.
  void require_lone_drive();
  void warn_of_unbounded_work() const;
  void print_can(std::FILE* out) const;
  void print_dds(std::FILE* out) const;

  EcuConfig config_;
  ProcessorLatency awake_;
  Crossings crossings_;
  PowerStage power_stage_;
  std::unique_ptr<Controller<double>> controller_;
  Drive<double> drive_;
  std::unique_ptr<CanBus> bus_;
  TelemetryProcess publisher_;
  ControlThread control_;
  CanReceiveThread receive_;
  CanTransmitThread transmit_;
  WatchdogThread watchdog_;
  PowerStageMonitor monitor_;
  HousekeepingThread housekeeping_;
  std::unique_ptr<TelemetryThread> telemetry_{};
};

}  // namespace sextant::ecu
