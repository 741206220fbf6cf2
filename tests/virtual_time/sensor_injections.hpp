#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "virtual_time/injection.hpp"

namespace sextant::test {

/// Largest difference between a phase current that the drive takes for true and the one that flows. [A]
inline double current_deviation(VirtualRig& rig, const Telemetry<double>& t) {
  const ThreePhase<double> real = rig.plant().i_abc();
  return largest({t.i_abc.a - real.a, t.i_abc.b - real.b, t.i_abc.c - real.c});
}

/// Above the limit of the sum and the tolerance of the gains, by what the offsets of real sensors can take
/// away from it.
inline bool sum_shows(VirtualRig& rig, const Telemetry<double>& t) {
  const ProtectionLimits<>& limits = rig.drive_parameters().protection;
  return current_deviation(rig, t) >
         limits.current_sum + limits.current_gain_tolerance * largest(t.i_abc) + 2.5;
}

/// The limit, and what the slip of 60 N·m allows for.
inline bool speed_shows(VirtualRig& rig, const Telemetry<double>& t) {
  return std::abs(t.omega_m - rig.plant().omega_m()) > rig.drive_parameters().protection.speed_error + 10.0;
}

/// Just inside: the smallest number above zero is added.
inline Injection not_a_number() {
  constexpr std::array values{std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};
  return {.name = "NaN or infinity",
          .fault = Fault::measurement_invalid,
          .bound_ns = period,
          .prepare = [values](CampaignCase& c) {
            const auto signal = static_cast<MeasuredSignal>(c.between(0, 4));
            const double bad = values[std::size_t(c.between(0, 2))];
            if (c.just_inside) {
              add_event(c, period,
                        {.signal = signal, .gain = 1.0, .offset = std::numeric_limits<double>::denorm_min()});
            } else {
              add_event(c, period, {.signal = signal, .offset = bad});
            }
          }};
}

/// A sensor whose reading departs from the current until the sum of the currents shows it.
inline Injection current_sensor_fault(const std::string& name, PlantFaultKind kind) {
  Injection departs = plant_fault(name, kind, Fault::current_sum, 5 * period, 200 * ms);
  departs.observable = "deviation above limit, gain tolerance and 2.5 A, without a break";
  departs.make_shows = always(sum_shows);
  departs.also = {Fault::current_sensor, Fault::open_phase};
  departs.must_last = true;
  return departs;
}

inline Injection current_sensor_drifts() {
  Injection drifts = current_sensor_fault("current sensor drifts", PlantFaultKind::current_drift);
  drifts.prepare = [](CampaignCase& c) {
    set_plant_fault(c, PlantFaultKind::current_drift, 200 * ms);
    c.rig.fault.drift = random_sign(c) * (c.just_inside ? 20.0 : 1000.0);  // at most 4 A
  };
  drifts.has_inside = true;
  return drifts;
}

/// Wrong currents make a wrong torque, which the torque monitor sees first while no vector is switched.
inline Injection current_sensors_swapped() {
  Injection swapped =
      plant_fault("current sensors swapped", PlantFaultKind::phases_swapped, Fault::current_sensor, 20 * ms);
  swapped.observable = "deviation above 4 A";
  swapped.make_shows =
      always([](VirtualRig& rig, const Telemetry<double>& t) { return current_deviation(rig, t) > 4.0; });
  swapped.also = {Fault::over_current, Fault::torque_plausibility};
  return swapped;
}

inline Injection current_converter_stopped() {
  return {.name = "current converter stopped",
          .fault = Fault::current_sensor,
          .observable = "deviation above 6 A",
          .bound_ns = 10 * ms,
          .prepare =
              [](CampaignCase& c) {
                wake_in_every_period(c);
                add_event(c, c.just_inside ? period : 100 * ms, {.holds_currents = true});
              },
          .make_shows = always(
              [](VirtualRig& rig, const Telemetry<double>& t) { return current_deviation(rig, t) > 6.0; })};
}

inline Injection current_reads_high() {
  return {.name = "current reads beyond its limit",
          .fault = Fault::over_current,
          .bound_ns = period,
          .prepare =
              [](CampaignCase& c) {
                const double limit = c.rig.config.drive.protection.over_current;
                add_event(c, period,
                          {.signal = static_cast<MeasuredSignal>(c.between(0, 2)),
                           .offset = random_sign(c) * (limit + 0.1 * double(c.between(1, 1000)))});
              },
          .has_inside = false};
}

inline Injection link_over_voltage() {
  return {.name = "link over-voltage",
          .fault = Fault::dc_over_voltage,
          .bound_ns = period,
          .prepare = [](CampaignCase& c) {
            const double limit = c.rig.config.drive.protection.dc_over_voltage;
            const double beyond = 0.1 * double(c.between(1, 1000));
            add_event(c, period,
                      {.signal = MeasuredSignal::u_dc, .offset = limit + (c.just_inside ? -1.0 : beyond)});
          }};
}

/// At 33 rad/s the step to zero is too small for a jump.
inline Injection speed_lost() {
  Injection lost = plant_fault("speed lost", PlantFaultKind::speed_lost, Fault::speed_sensor, 10 * ms);
  lost.points = {{{33.0, 5.0}, {100.0, 60.0}, {-80.0, -15.0}}};
  lost.also = {Fault::torque_plausibility};
  return lost;
}

// A wrong speed makes a wrong torque, which the torque monitor may see first; just inside it is off.

inline Injection speed_frozen() {
  return {.name = "speed frozen",
          .fault = Fault::speed_sensor,
          .observable = "error above limit and slip of 60 N·m",
          .bound_ns = 10 * ms,
          .prepare =
              [](CampaignCase& c) {
                c.rig.config.drive.torque_monitor.enabled = !c.just_inside;
                const double inside = c.rig.omega_m - std::copysign(15.0, c.rig.omega_m);
                ramp_speed(c, c.just_inside ? inside : 0.25 * c.rig.omega_m, 100 * ms, 50 * ms);
                set_plant_fault(c, PlantFaultKind::speed_frozen, 250 * ms);
              },
          .make_shows = always(speed_shows),
          .lasts_ns = 300 * ms,
          .points = turning_points,
          .also = {Fault::torque_plausibility}};
}

inline Injection speed_jumps() {
  return {.name = "speed jumps",
          .fault = Fault::speed_sensor,
          .observable = "error above limit and slip of 60 N·m",
          .bound_ns = 10 * ms,
          .prepare =
              [](CampaignCase& c) {
                c.rig.config.drive.torque_monitor.enabled = !c.just_inside;
                set_plant_fault(c, PlantFaultKind::speed_jump, 100 * ms);
                c.rig.fault.jump = random_sign(c) * (c.just_inside ? 15.0 : double(c.between(30, 90)));
              },
          .make_shows = always(speed_shows),
          .points = turning_points,
          .also = {Fault::torque_plausibility}};
}

/// Of measurements and sensors.
inline std::vector<Injection> sensor_injections() {
  return {not_a_number(),
          current_sensor_fault("current sensor stuck", PlantFaultKind::current_stuck),
          current_sensor_fault("current sensor open", PlantFaultKind::current_zero),
          current_sensor_drifts(),
          current_sensors_swapped(),
          current_converter_stopped(),
          current_reads_high(),
          link_over_voltage(),
          speed_lost(),
          speed_frozen(),
          speed_jumps()};
}

}  // namespace sextant::test
