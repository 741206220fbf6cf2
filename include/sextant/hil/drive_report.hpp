#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant {

/// Drive → plant in lockstep, one a control period: what a run that is observed at the plant needs of its
/// drive. Fixed-width members without padding, as the records of the link (link_records.hpp).
struct DriveReport {
  std::uint64_t latched{};      ///< faults, as the bits of `FaultSet`
  std::int64_t begin_ns{};      ///< time zero of the scenario that the drive plays, on its clock [ns]
  float torque_motoring{};      ///< available, magnitude [N·m]
  float torque_regenerating{};  ///< available, magnitude [N·m]
  float torque_reference{};     ///< [N·m]
  float torque_reached{};       ///< [N·m]
  std::uint8_t state{};         ///< as `DriveState`
  std::uint8_t first_fault{};   ///< as `Fault`; meaningful while `latched` is not 0
  std::array<std::uint8_t, 2> reserved{};
  std::uint32_t scenario{};  ///< mark of the scenario that the drive plays; 0: none, begin_ns means nothing
};

static_assert(sizeof(DriveReport) == 40 && std::is_trivially_copyable_v<DriveReport>);
static_assert(offsetof(DriveReport, torque_motoring) == 16 && offsetof(DriveReport, state) == 32 &&
              offsetof(DriveReport, scenario) == 36);

/// begin_ns: time zero of the scenario on the drive's clock [ns]; scenario: its mark.
[[nodiscard]] inline DriveReport to_report(const Telemetry<double>& telemetry, std::int64_t begin_ns,
                                           std::uint32_t scenario) noexcept SEXTANT_NONBLOCKING {
  return {.latched = telemetry.latched.bits(),
          .begin_ns = begin_ns,
          .torque_motoring = float(telemetry.torque_motoring),
          .torque_regenerating = float(telemetry.torque_regenerating),
          .torque_reference = float(telemetry.torque_reference),
          .torque_reached = float(telemetry.torque_reached),
          .state = std::uint8_t(telemetry.state),
          .first_fault = std::uint8_t(telemetry.first_fault),
          .scenario = scenario};
}

/// The members of the telemetry that the report has; the others are those of no telemetry. The period begins
/// at t_ns [ns] with that measured speed [rad/s].
[[nodiscard]] inline Telemetry<double> to_telemetry(const DriveReport& report, std::int64_t t_ns,
                                                    double omega_m) noexcept {
  Telemetry<double> telemetry{.t_ns = t_ns,
                              .omega_m = omega_m,
                              .torque_reference = double(report.torque_reference),
                              .torque_reached = double(report.torque_reached),
                              .torque_motoring = double(report.torque_motoring),
                              .torque_regenerating = double(report.torque_regenerating),
                              .first_fault = static_cast<Fault>(report.first_fault),
                              .state = static_cast<DriveState>(report.state)};
  for (int k = 0; k < fault_count; ++k) {
    if ((report.latched >> unsigned(k) & 1U) != 0) telemetry.latched.set(static_cast<Fault>(k));
  }
  return telemetry;
}

}  // namespace sextant
