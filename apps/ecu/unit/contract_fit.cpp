#include "ecu/unit/contract_fit.hpp"

#include <array>
#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sextant/comms/contract_ranges.hpp"

namespace sextant::ecu {
namespace {

constexpr double rpm_per_rad_s = 30.0 / std::numbers::pi;

/// A signal and the largest value that the drive has for it, by that key.
struct Demand {
  SignalRange signal;
  double value;  ///< [the signal's unit]
  const char* key;
};

std::array<Demand, 6> demands(const DriveConfig& config) {
  const ContractRanges ranges = contract_ranges();
  const Drive<>::Parameters& drive = config.drive;
  return {{{ranges.torque_request, drive.command.torque_limit, "command.torque_limit_nm"},
           {ranges.torque_available, drive.motor.capability.torque, "capability.torque_nm"},
           {ranges.flux, config.control.flux_reference, "control.flux_reference_wb"},
           {ranges.link_voltage, drive.protection.dc_over_voltage, "protection.dc_over_voltage_v"},
           {ranges.phase_current, drive.protection.over_current / std::numbers::sqrt2,
            "protection.over_current_a as RMS"},
           {ranges.speed, drive.protection.over_speed * rpm_per_rad_s, "protection.over_speed_rad_s"}}};
}

}  // namespace

std::string beyond_contract(const DriveConfig& config) {
  std::vector<std::string> beyond;
  for (const Demand& demand : demands(config)) {
    const SignalRange& signal = demand.signal;
    if (signal.contains(demand.value)) continue;
    beyond.push_back(fmt::format("{} carries {:g} to {:g} {}, and {} is {:.4g} {}", signal.name,
                                 signal.lowest, signal.highest, signal.unit, demand.key, demand.value,
                                 signal.unit));
  }
  if (beyond.empty()) return "";
  return fmt::format("{}: no more can be commanded, and status beyond it is sent as the end of its range",
                     fmt::join(beyond, "; "));
}

}  // namespace sextant::ecu
