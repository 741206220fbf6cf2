#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "ecu/can_receive_thread.hpp"
#include "ecu/can_transmit_thread.hpp"
#include "ecu/control_thread.hpp"
#include "ecu/crossings.hpp"
#include "ecu/telemetry_thread.hpp"
#include "ecu/watchdog_thread.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant::ecu {

/// The live drive: control core, simulated power stage, CAN and DDS, and the five threads that join them.
class Ecu {
 public:
  /// Opens everything. Throws std::runtime_error with one sentence where something cannot be had.
  explicit Ecu(const EcuConfig& config);
  ~Ecu();

  /// Starts the threads. Throws when real-time rights are required and refused.
  void start();

  /// Torque to zero, gates off, threads joined. Safe to call twice.
  void stop();

  /// What happened, for people.
  void print_report(std::FILE* out) const;

 private:
  void judge_rights(const std::vector<std::string>& refusals) const;
  void print_commands(std::FILE* out) const;
  void print_can(std::FILE* out) const;
  void print_dds(std::FILE* out) const;

  EcuConfig config_;
  Crossings crossings_;
  SimulatedPowerStage power_stage_;
  std::unique_ptr<Controller<double>> controller_;
  Drive<double> drive_;
  std::unique_ptr<CanBus> bus_;
  DdsTelemetry dds_;
  ControlThread control_;
  CanReceiveThread receive_;
  CanTransmitThread transmit_;
  WatchdogThread watchdog_;
  std::unique_ptr<TelemetryThread> telemetry_{};
};

}  // namespace sextant::ecu
