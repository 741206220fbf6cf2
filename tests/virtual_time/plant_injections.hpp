#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "virtual_time/injection.hpp"

namespace sextant::test {

/// A torque whose current is beyond the trip level, with a current limit that allows it.
inline Injection over_current() {
  return {.name = "over-current",
          .fault = Fault::over_current,
          .observable = "reading above limit + 1 A",
          .bound_ns = period,
          .prepare =
              [](CampaignCase& c) {
                wake_in_every_period(c);
                c.rig.config.drive.protection.over_current = c.just_inside ? 60.0 : 32.0;
                direct_torque(c.rig.config).magnetiser.current_limit = 20.0;
                direct_torque(c.rig.config).magnetiser.hand_over_current = 20.0;
                c.start_torque = 0.1 * c.rig.torque;
                c.rig.torque = std::copysign(120.0, c.rig.torque);
              },
          .inject = [](VirtualRig& rig, const CampaignCase& c) { rig.torque = c.rig.torque; },
          .make_shows = always([](VirtualRig& rig, const Telemetry<double>& t) {
            return largest(t.i_abc) > rig.drive_parameters().protection.over_current + 1.0;
          })};
}

inline Injection link_under_voltage() {
  return {.name = "link under-voltage",
          .fault = Fault::dc_under_voltage,
          .observable = "reading below limit",
          .bound_ns = 1 * ms,
          .prepare =
              [](CampaignCase& c) {
                set_plant_fault(c, PlantFaultKind::link_sag, 100 * ms);
                c.rig.fault.sag_voltage = c.just_inside ? 275.0 : double(c.between(150, 250));
                c.rig.fault.ramp_ns = c.between(0, 50) * ms;
              },
          .make_shows = always([](VirtualRig& rig, const Telemetry<double>& t) {
            return t.u_dc < rig.drive_parameters().protection.dc_under_voltage;
          })};
}

inline Injection over_speed() {
  return {.name = "over-speed",
          .fault = Fault::over_speed,
          .observable = "reading above limit",
          .bound_ns = period,
          .prepare =
              [](CampaignCase& c) {
                wake_in_every_period(c);
                c.rig.config.drive.protection.over_speed = 110.0;
                ramp_speed(c, std::copysign(c.just_inside ? 108.0 : 120.0, c.rig.omega_m), 50 * ms, 50 * ms);
              },
          .make_shows = always([](VirtualRig& rig, const Telemetry<double>& t) {
            return std::abs(t.omega_m) > rig.drive_parameters().protection.over_speed;
          }),
          .lasts_ns = 200 * ms,
          .points = turning_points};
}

/// Temperature by the model of the drive, a period a step, with what the current sensors read.
inline Injection::Shows winding_shows() {
  struct Model {
    double temperature;
  };
  return [model = Model{std::nan("")}](VirtualRig& rig, const Telemetry<double>&) mutable {
    const ProtectionLimits<>& limits = rig.drive_parameters().protection;
    if (std::isnan(model.temperature)) model.temperature = limits.winding.ambient;
    const ThreePhase<double>& i = rig.io.currents();
    const double squares = (i.a * i.a + i.b * i.b + i.c * i.c) / 3.0;
    const double nominal = limits.winding.nominal_current;
    const double rise = limits.winding.nominal_rise * squares / (nominal * nominal);
    const double share = double(VirtualRig::period_ns) * 1e-9 / limits.winding.time_constant;
    model.temperature += share * (limits.winding.ambient + rise - model.temperature);
    return model.temperature > limits.winding_trip + 1.0;
  };
}

/// The magnetising current of 9 A RMS heats a small winding by 82 K with a time constant of a second, or by
/// 23 K just inside.
inline Injection winding_too_hot() {
  return {.name = "winding too hot",
          .fault = Fault::over_temperature,
          .observable = "temperature by the same model 1 K above its trip",
          .bound_ns = 100 * ms,
          .prepare =
              [](CampaignCase& c) {
                wake_in_every_period(c);
                c.rig.config.drive.protection.winding = {.nominal_current = c.just_inside ? 17.0 : 9.0,
                                                         .time_constant = 1.0};
                c.rig.config.drive.protection.winding_warning = 90.0;
                c.rig.config.drive.protection.winding_trip = 100.0;
                c.rig.torque = std::copysign(10.0, c.rig.torque);
              },
          .make_shows = winding_shows,
          .lasts_ns = 2'500 * ms};
}

/// Mean of a millisecond of the plant's torque against the reference.
inline Injection::Shows torque_shows(double deviation) {
  struct Mean {
    double sum{0.0};
    int periods{0};
    bool deviates{false};
  };
  return [deviation, mean = Mean{}](VirtualRig& rig, const Telemetry<double>& t) mutable {
    mean.sum += rig.plant().tau_e() - t.torque_reference;
    if (++mean.periods < 40) return mean.deviates;
    mean.deviates = std::abs(mean.sum) > 40.0 * deviation;
    mean.sum = 0.0;
    mean.periods = 0;
    return mean.deviates;
  };
}

/// The controller believes in a rotor that it does not have, and a torque step shows it.
inline Injection torque_deviates() {
  return {.name = "torque deviates",
          .fault = Fault::torque_plausibility,
          .observable = "mean of 1 ms off by 24 N·m (limit and band at 60 N·m), without a break",
          .bound_ns = 10 * ms,
          .prepare =
              [](CampaignCase& c) {
                wake_in_every_period(c);
                c.rig.config.drive.magnetise_first = false;  // which would identify the rotor
                direct_torque(c.rig.config).flux_estimator = FluxEstimatorKind::current_model;
                direct_torque(c.rig.config).machine.r_r *= c.just_inside ? 1.05 : 3.0;
                c.rig.torque = 0.0;
              },
          .inject = [](VirtualRig& rig,
                       const CampaignCase& c) { rig.torque = std::copysign(60.0, c.rig.omega_m); },
          .make_shows = [] { return torque_shows(24.0); },
          .lasts_ns = 300 * ms,
          .points = {{{60.0, 0.0}, {100.0, 0.0}, {-80.0, 0.0}}},
          .must_last = true};
}

/// A current crosses zero within a period; that of an open phase stays there.
inline Injection::Shows open_phase_shows() {
  return [in_a_row = 0](VirtualRig& rig, const Telemetry<double>&) mutable {
    const ThreePhase<double> i = rig.plant().i_abc();
    const double smallest = std::min({std::abs(i.a), std::abs(i.b), std::abs(i.c)});
    in_a_row = smallest < 1e-3 ? in_a_row + 1 : 0;
    return in_a_row >= 3 && largest(i) > 5.0;
  };
}

/// Voltages along the open phase move no current at all: none of the phases answers then, as of a sensor.
/// The contact carries the current until it crosses zero: up to 0.8 s with 15 N·m at standstill.
inline Injection open_phase() {
  Injection open =
      plant_fault("open phase", PlantFaultKind::open_phase, Fault::open_phase, 20 * ms, 900 * ms);
  open.observable = "no current in the phase for 3 periods, 5 A in another";
  open.make_shows = open_phase_shows;
  open.also = {Fault::current_sensor};
  return open;
}

/// With sectors 90° off the table takes the flux of a standing or braking machine away. Just inside: for
/// less than the time of the rule.
inline Injection flux_lost() {
  return {.name = "flux lost",
          .fault = Fault::flux_lost,
          .observable = "estimate below half of the reference under torque, without a break",
          .bound_ns = 201 * ms,
          .prepare =
              [](CampaignCase& c) {
                wake_in_every_period(c);
                direct_torque(c.rig.config).flux_priority = false;
                direct_torque(c.rig.config).sector.sector_start_deg = 60.0;
                c.rig.config.drive.torque_monitor.enabled = false;
                c.rig.config.drive.protection.speed_error = 1e6;
                c.rig.vehicle.first_ns += 50 * ms;
                if (c.just_inside) c.rig.config.drive.protection.flux_lost_ns = 1'000 * ms;
              },
          .make_shows = always([](VirtualRig& rig, const Telemetry<double>& t) {
            const double limit = 0.5 * rig.drive_parameters().motor.capability.flux_reference;
            return makes_torque(t.state) && t.psi_s_magnitude < limit;
          }),
          .lasts_ns = 600 * ms,
          .points = {{{0.0, -15.0}, {0.0, -40.0}, {-60.0, -15.0}}},
          .must_last = true};
}

/// Of link, machine, winding, shaft and controller.
inline std::vector<Injection> plant_injections() {
  return {over_current(),    link_under_voltage(), over_speed(), winding_too_hot(),
          torque_deviates(), open_phase(),         flux_lost()};
}

}  // namespace sextant::test
