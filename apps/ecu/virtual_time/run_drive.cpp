#include "ecu/virtual_time/run_drive.hpp"

#include <fmt/format.h>

#include "ecu/timing/timing_report.hpp"
#include "ecu/unit/run_report.hpp"

namespace sextant::ecu {

RunDrive::RunDrive(const EcuConfig& config, DriveIo<double>& io, VirtualCanBus& bus,
                   const std::string& record_cycles)
    : unit_{config, io, bus, [] {}, record_cycles},
      periods_per_record_{periods_per_sample(config)},
      recorder_{periods_per_record_, {.record = [this](const TelemetryIntervalRecord<double>& record) {
                  if (telemetry_) telemetry_->add(record);
                }}} {}

void RunDrive::open(const std::string& telemetry_out, std::int64_t first_period_ns) {
  if (!telemetry_out.empty()) {
    telemetry_.emplace(telemetry_out, unit_.config().drive.drive.period_ns, periods_per_record_,
                       first_period_ns);
  }
  if (CycleLog* const cycles = unit_.cycles()) cycles->open();
}

void RunDrive::record_cycles() {
  if (CycleLog* const cycles = unit_.cycles()) cycles->poll();
}

void RunDrive::close() {
  if (telemetry_) telemetry_->close();
  if (CycleLog* const cycles = unit_.cycles()) cycles->close();
}

std::string RunDrive::failure() const {
  return unit_.cycles() == nullptr ? std::string{} : unit_.cycles()->failure();
}

Verdict RunDrive::verdict() const {
  if (end_.latched.any()) return Verdict::tripped;
  return vehicle_ && !vehicle_->enabled_ns() ? Verdict::no_torque : Verdict::pass;
}

void RunDrive::print_periods_and_commands(std::FILE* out, const WakeSchedule::Counters& wakes) const {
  print_periods(out, recorder_.periods(), wakes.periods_missed, wakes.overruns);
  print_commands(out, unit_.receive().receiver(), unit_.config().can.identifier_offset);
}

void RunDrive::print_end(std::FILE* out) const {
  if (const CycleLog* const cycles = unit_.cycles()) cycles->print_report(out);
  fmt::print(out, "left in {}, {} faults", to_string(end_.state), end_.fault_total);
  if (end_.latched.any()) fmt::print(out, ", first {}", to_string(end_.first_fault));
  fmt::print(out, "\ndigest {:016x}: telemetry {:016x}, frames {:016x}\n", recorder_.digest(),
             recorder_.telemetry_digest(), recorder_.frames_digest());
}

}  // namespace sextant::ecu
