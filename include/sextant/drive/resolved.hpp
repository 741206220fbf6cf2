#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/control/control_basis.hpp"
#include "sextant/core/drive_limits.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/drive/drive_setup.hpp"

namespace sextant {

/// A `DriveSetup` in which every value is set.
template <class T = double>
struct ResolvedDrive {
  ControlBasis<T> control{};  ///< for the parameters of the drive's controller
  typename Drive<T>::Parameters drive{};

  [[nodiscard]] const char* validate() const noexcept {
    if (const char* problem = control.validate()) return problem;
    if (const char* problem = control.winding.validate()) return problem;
    if (!(drive.motor.capability.current_limit < drive.protection.over_current)) {
      return "the current limit must be below the current trip";
    }
    return drive.validate();
  }
};

/// Five rotor time constants, at least 1 s: by the check of `Magnetiser` of its current limit the flux is
/// ready after three. [ms]
template <class T>
[[nodiscard]] T default_magnetise_timeout_ms(const InductionMachineParameters<T>& machine) noexcept {
  return std::max(T(1000), T(5e3) * machine.tau_r());
}

/// Whole nanoseconds of a time of up to 2e9 ms; longer ones count as that, none and negative ones as zero. In
/// two parts, because a Cortex-M4F converts a `float` to 64 bits by double arithmetic.
template <class T>
[[nodiscard]] std::int64_t whole_ns(T time_ms) noexcept {
  if (!(time_ms > T(0))) return 0;
  const T most = T(2e9);
  const T ms = time_ms < most ? time_ms : most;
  const auto whole_ms = std::int32_t(ms);
  return std::int64_t{whole_ms} * 1'000'000 + std::lround((ms - T(whole_ms)) * T(1e6));
}

template <class T>
[[nodiscard]] CommandLimits<T> command_limits(const CommandSetup<T>& s,
                                              const DriveLimits<T>& limits) noexcept {
  return {.torque_limit = s.torque_limit.value_or(limits.torque),
          .torque_rate = s.torque_rate,
          .timeout_ns = s.timeout_ns,
          .zero_ramp_ns = s.zero_ramp_ns,
          .lost_ns = s.lost_ns,
          .status_timeout_ns = s.status_timeout_ns,
          .status_lost_ns = s.status_lost_ns,
          .blocked_limit = s.blocked_limit};
}

/// basis: with the voltage error of its inverter; torque_limit: of the commands. [N·m]
template <class T>
[[nodiscard]] ProtectionLimits<T> protection_limits(const ProtectionSetup<T>& s, const DriveBasis<T>& basis,
                                                    const DriveLimits<T>& limits, T torque_limit) noexcept {
  const T over_current = s.over_current.value_or(limits.over_current);
  const T dc_over_voltage = s.dc_over_voltage.value_or(limits.dc_over_voltage);
  const T over_speed = s.over_speed.value_or(limits.over_speed);
  const CurrentSensorLimits<T> sensors =
      current_sensor_limits(basis.machine, over_current, basis.u_dc, T(basis.period_ns) * T(1e-9));
  return {.over_current = over_current,
          .dc_over_voltage = dc_over_voltage,
          .over_speed = over_speed,
          .dc_under_voltage = s.dc_under_voltage.value_or(limits.dc_under_voltage),
          // A reading beyond them comes from no sensor: a broken converter or link.
          .current_range = s.current_range.value_or(T(10) * over_current),
          .voltage_range = s.voltage_range.value_or(T(10) * dc_over_voltage),
          .speed_range = s.speed_range.value_or(T(10) * over_speed),
          .current_sum = s.current_sum.value_or(sensors.sum),
          .current_gain_tolerance = s.current_gain_tolerance,
          .current_offset = s.current_offset.value_or(limits.current_offset),
          .current_jump = s.current_jump.value_or(sensors.jump),
          .current_response = s.current_response,
          .current_noise = s.current_noise.value_or(sensors.noise),
          .zero_current = s.zero_current.value_or(sensors.zero_current),
          .current_step = s.current_step.value_or(sensors.step),
          .speed_jump = s.speed_jump.value_or(limits.speed_jump),
          .speed_error = s.speed_error.value_or(limits.speed_error),
          .speed_error_ns = s.speed_error_ns,
          .flux_lost_share = s.flux_lost_share,
          .flux_lost_torque = s.flux_lost_torque.value_or(T(0.05) * torque_limit),
          .flux_lost_ns = s.flux_lost_ns,
          .winding_warning = s.winding_warning,
          .winding_trip = s.winding_trip,
          .winding = s.winding,
          .machine = basis.machine,
          .inverter = basis.inverter,
          .period_ns = basis.period_ns};
}

/// torque_limit: of the commands [N·m]; current_limit: of the stator current vector. [A]
template <class T>
[[nodiscard]] typename TorqueCapability<T>::Parameters capability_parameters(const CapabilitySetup<T>& s,
                                                                             const DriveBasis<T>& basis,
                                                                             T torque_limit,
                                                                             T current_limit) noexcept {
  return {.machine = basis.machine,
          .flux_reference = basis.flux_reference,
          .voltage_use = s.voltage_use,
          .breakdown_use = s.breakdown_use,
          .current_limit = current_limit,
          .torque = s.torque.value_or(torque_limit),
          .base_speed = s.base_speed,
          .zero_torque_speed = s.zero_torque_speed};
}

/// From `full` to `zero`, by default three quarters of the way to the trip level; all are link voltages. [V]
template <class T>
[[nodiscard]] typename LinkVoltageBand<T>::Parameters link_voltage_band(const std::optional<T>& full,
                                                                        const std::optional<T>& zero,
                                                                        T trip) noexcept {
  if (!full) return {T(0), zero.value_or(T(0))};
  return {*full, zero.value_or(T(0.25) * *full + T(0.75) * trip)};
}

/// phase_offset: largest one of a phase current's sensor. [A]
template <class T>
[[nodiscard]] TorqueMonitorLimits<T> torque_monitor_limits(const TorqueMonitorSetup<T>& s,
                                                           const DriveBasis<T>& basis,
                                                           const DriveLimits<T>& limits,
                                                           T phase_offset) noexcept {
  TorqueMonitorLimits<T> p{.enabled = s.enabled,
                           .machine = s.machine.value_or(basis.machine),
                           .saturation = basis.saturation,
                           .inverter = basis.inverter,
                           .iron_loss_resistance = basis.iron_loss_resistance,
                           .flux_reference = basis.flux_reference,
                           .limit = s.limit.value_or(limits.torque_deviation),
                           .limit_share = s.limit_share,
                           .time_ns = s.time_ns,
                           .r_s_share = s.r_s_share,
                           .r_r_share = s.r_r_share,
                           .l_m_share = s.l_m_share,
                           .sensor_share = s.sensor_share};
  p.wrong_sign = s.wrong_sign.value_or(T(0.5) * p.limit);
  // Of a vector whose phases are off by as much, two of them in the other direction.
  p.current_offset = T(4) / T(3) * phase_offset;
  return p;
}

/// Every default rule of a drive, in order: limits from machine, flux reference and link (`drive_limits`),
/// and what follows from these or from what is given in their place. For the setup's `validate` to have
/// found nothing.
template <class T>
[[nodiscard]] ResolvedDrive<T> resolved(const DriveSetup<T>& setup) noexcept {
  ResolvedDrive<T> r;
  DriveBasis<T> basis = setup.basis;
  // The same curve, by the inductance at the flux reference: that is the machine of all limits.
  const SaturationCurve<T> curve{basis.saturation, basis.machine.l_s()};
  const auto at_reference = [&curve, &basis](const InductionMachineParameters<T>& machine) {
    return curve.machine_at(machine, {basis.flux_reference, T(0)});
  };
  basis.machine = at_reference(basis.machine);
  basis.saturation.machine_flux = basis.flux_reference;
  basis.iron_loss_resistance = setup.optimal_flux.iron_loss_resistance;
  basis.inverter.voltage_error =
      setup.voltage_error.value_or(basis.inverter.likely_voltage_error(basis.period_ns, basis.u_dc));
  const DriveLimits<T> limits = drive_limits(basis.machine, basis.flux_reference, basis.u_dc);

  r.drive.period_ns = basis.period_ns;
  r.drive.sampling_lead_ns = basis.sampling_lead_ns;
  r.drive.magnetise_first = setup.magnetise_first;
  r.drive.magnetise_timeout_ns =
      whole_ns(setup.magnetise_timeout_ms.value_or(default_magnetise_timeout_ms(basis.machine)));
  r.drive.command = command_limits(setup.command, limits);
  r.drive.protection = protection_limits(setup.protection, basis, limits, r.drive.command.torque_limit);
  r.drive.motor.capability =
      capability_parameters(setup.capability, basis, r.drive.command.torque_limit,
                            setup.current_limit.value_or(T(0.8) * r.drive.protection.over_current));
  r.drive.low_voltage = link_voltage_band(setup.capability.low_voltage, setup.capability.low_voltage_zero,
                                          r.drive.protection.dc_under_voltage);
  r.drive.high_voltage = link_voltage_band(setup.capability.high_voltage, setup.capability.high_voltage_zero,
                                           r.drive.protection.dc_over_voltage);
  r.drive.ready_voltage = setup.capability.ready_voltage.value_or(
      std::max(r.drive.low_voltage.zero, r.drive.protection.dc_under_voltage));
  r.drive.motor.optimal_flux = setup.optimal_flux;
  r.drive.anti_jerk = setup.anti_jerk;
  r.drive.torque_monitor =
      torque_monitor_limits(setup.torque_monitor, basis, limits, r.drive.protection.current_offset);
  if (setup.torque_monitor.machine)
    r.drive.torque_monitor.machine = at_reference(*setup.torque_monitor.machine);

  static_cast<DriveBasis<T>&>(r.control) = basis;
  r.control.flux_estimator = setup.flux_estimator;
  r.control.adapts_parameters = setup.adapts_parameters;
  r.control.winding = setup.winding;
  r.control.current_limit = r.drive.motor.capability.current_limit;
  return r;
}

}  // namespace sextant
