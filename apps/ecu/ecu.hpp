#pragma once

#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "ecu/live_drive.hpp"
#include "ecu/parameters/load_drives.hpp"
#include "ecu/telemetry/telemetry_process.hpp"
#include "ecu/threads/bus_watch.hpp"
#include "ecu/threads/polled_thread.hpp"
#include "ecu/threads/receive_thread.hpp"
#include "ecu/unit/fault_reaction.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/config/drives_config.hpp"
#include "sextant/realtime/processor_latency.hpp"

namespace sextant::ecu {

/// The process of live drives: CAN bus, clock and threads, with the drives. Each has a control thread of its
/// own; every other thread works for all of them. The threads and the process for DDS run on the CPUs of the
/// caller; see keep_off_cpu().
class Ecu {
 public:
  /// Opens power stages, bus and publisher. Throws std::runtime_error with one sentence where one cannot be
  /// opened. load: the configuration with further overrides, for parameters that the drives take.
  explicit Ecu(const DrivesConfig& config, const LiveDriveOptions& options = {}, const LoadDrives& load = {});
  ~Ecu();

  /// Starts the threads. Throws when real-time rights are required and refused.
  void start();

  /// Torque to zero, gates off, threads joined. Safe to call twice.
  void stop();

  /// Why the run ended early; empty where it did not.
  [[nodiscard]] std::string problem() const;

  /// The timing of the run, for programs: a file for each drive, by DrivesConfig::file_of. Throws
  /// std::runtime_error where the file cannot be written.
  void write_timing(const std::string& file) const;

  /// The report of the run, for people.
  void print_report(std::FILE* out) const;

 private:
  /// Receives for a while before the first frame is sent. Throws where another drive is on the bus.
  void require_lone_drives();
  void start_threads();
  void start_transmission();
  [[nodiscard]] std::chrono::nanoseconds transmit();
  void poll_links();
  [[nodiscard]] const std::string& bus_name() const noexcept { return config_.drives.front().can.bus; }
  template <class Function>
  void each(Function&& function) {
    for (const std::unique_ptr<LiveDrive>& drive : drives_) function(*drive);
  }

  std::atomic<bool> is_over_{false};          // no control thread runs
  std::atomic<bool> cycles_are_over_{false};  // nothing can come for a recording
  DrivesConfig config_;
  ProcessorLatency processor_latency_;
  std::unique_ptr<CanBus> bus_;
  std::vector<std::unique_ptr<LiveDrive>> drives_{};
  TelemetryProcess publisher_;
  FaultReaction reaction_;
  ReceiveThread receive_;
  BusWatch bus_watch_;
  bool is_asked_to_end_{false};  // of the link thread
  PolledThread transmit_{"sextant-can-tx", is_over_};
  PolledThread watchdog_{"sextant-wdog", is_over_};
  PolledThread link_{"sextant-link", is_over_};
  PolledThread housekeeping_{"sextant-house", is_over_};
  PolledThread telemetry_{"sextant-dds", is_over_};
  PolledThread cycles_{"sextant-cycles", cycles_are_over_};
};

}  // namespace sextant::ecu
