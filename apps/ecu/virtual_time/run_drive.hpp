#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include "ecu/telemetry/telemetry_file.hpp"
#include "ecu/unit/drive_unit.hpp"
#include "ecu/virtual_time/virtual_unit.hpp"
#include "sextant/run/verdict.hpp"
#include "sextant/virtual_time/run_recorder.hpp"
#include "sextant/virtual_time/virtual_can_bus.hpp"
#include "sextant/virtual_time/virtual_vehicle.hpp"

namespace sextant::ecu {

/// A drive of a run in virtual time, with its files and the vehicle that commands it.
class RunDrive {
 public:
  /// Power stage and bus are not owned and must outlive this object. record_cycles: file for the control
  /// periods; empty for none.
  RunDrive(const EcuConfig& config, DriveIo<double>& io, VirtualCanBus& bus,
           const std::string& record_cycles);
  RunDrive(const RunDrive&) = delete;
  RunDrive& operator=(const RunDrive&) = delete;

  [[nodiscard]] DriveUnit& unit() noexcept { return unit_; }
  [[nodiscard]] const DriveUnit& unit() const noexcept { return unit_; }
  [[nodiscard]] RunRecorder& recorder() noexcept { return recorder_; }
  [[nodiscard]] const RunRecorder& recorder() const noexcept { return recorder_; }
  [[nodiscard]] std::optional<VirtualVehicle>& vehicle() noexcept { return vehicle_; }
  [[nodiscard]] const std::optional<VirtualVehicle>& vehicle() const noexcept { return vehicle_; }

  /// Opens the files. telemetry_out: empty for none. first_period_ns: the first control period [ns].
  void open(const std::string& telemetry_out, std::int64_t first_period_ns);
  void record_cycles();
  void close();
  /// Why the recording of the control periods has ended before its end; empty where it has not.
  [[nodiscard]] std::string failure() const;

  /// The state now is that at the end, before the shutdown.
  void note_end() { end_ = unit_.control().last(); }
  [[nodiscard]] const Telemetry<double>& end() const noexcept { return end_; }

  /// How it turned out: `no_torque` where the drive never got ready for a vehicle, `tripped` where it was in
  /// FAULT at the end, else `pass`.
  [[nodiscard]] Verdict verdict() const;

  void print_periods_and_commands(std::FILE* out, const WakeSchedule::Counters& wakes) const;
  void print_end(std::FILE* out) const;

 private:
  DriveUnit unit_;
  std::uint32_t periods_per_record_;
  std::optional<TelemetryFile> telemetry_{};
  RunRecorder recorder_;
  std::optional<VirtualVehicle> vehicle_{};
  Telemetry<double> end_{};
};

}  // namespace sextant::ecu
