#include <cmath>
#include <optional>

#include "drive_sections.hpp"

namespace sextant {
namespace {

constexpr Range<double> sensor_current_a{1e-6, 1e9};

void describe_current_sensors(Section& s, ProtectionSetup<>& p, const ProtectionLimits<>& resolved) {
  s.derived("current_sum_a", p.current_sum, resolved.current_sum, sensor_current_a, "A",
            "largest magnitude of the sum of the phase currents, plus current_gain_tolerance of the largest "
            "of them; more in three control periods is CURRENT_SUM");
  s.number("current_gain_tolerance", p.current_gain_tolerance, {0, 0.99}, "",
           "errors of the current sensors' gains, as a share of the largest phase current: added to "
           "current_sum_a");
  s.derived("current_offset_a", p.current_offset, resolved.current_offset, sensor_current_a, "A",
            "largest offset of a phase current's sensor, its mean reading with the gates off: removed from "
            "the controller's currents, allowed for by the torque monitor; a larger one is CURRENT_SENSOR");
  s.derived(
      "current_jump_a", p.current_jump, resolved.current_jump, sensor_current_a, "A",
      "largest change of a phase current in a control period beside that by the voltage; more, twice in a "
      "row, is CURRENT_SENSOR; by half of it the model may move currents whose readings stand still");
  s.number("current_response", p.current_response, {0, 0.99}, "",
           "smallest measured change of a phase current, as a share of that by the machine's parameters, "
           "over 3 ms; less is CURRENT_SENSOR, or OPEN_PHASE at zero_current_a; 0: neither");
  s.derived("current_noise_a", p.current_noise, resolved.current_noise, sensor_current_a, "A",
            "standard deviation of the noise of a measured phase current: the larger, the more switching the "
            "response needs before it counts");
  s.derived("zero_current_a", p.zero_current, resolved.zero_current, sensor_current_a, "A",
            "largest reading of a phase without current; a phase that stays below it and does not respond is "
            "OPEN_PHASE");
  s.derived("current_step_a", p.current_step, resolved.current_step, {0, 1e5}, "A",
            "step of the current sensors' converter: readings that differ by no more are equal; 0: none");
}

/// A reading beyond them comes from no sensor: a broken converter or link.
void describe_ranges(Section& s, ProtectionSetup<>& p, const ProtectionLimits<>& resolved) {
  s.derived("current_range_a", p.current_range, resolved.current_range, {1e-3, 1e7}, "A",
            "largest magnitude that a current sensor can read; more is MEASUREMENT_INVALID");
  s.derived("voltage_range_v", p.voltage_range, resolved.voltage_range, {1, 2e5}, "V",
            "largest voltage of the DC link that its sensor can read; more is MEASUREMENT_INVALID");
  s.derived("speed_range_rad_s", p.speed_range, resolved.speed_range, {1e-3, 1e5}, "rad/s",
            "largest magnitude that the speed sensor can read; more is MEASUREMENT_INVALID");
}

void describe_winding(Section s, ProtectionSetup<>& p) {
  WindingTemperature<>::Parameters& w = p.winding;
  s.add(
      "nominal_current_a", "A",
      "RMS of a phase current that the winding bears for good, by the nameplate, for a thermal model of it; "
      "not set: no model, and the winding is not protected",
      NumberField{
          {1e-3, 1e5},
          [&w] { return std::isfinite(w.nominal_current) ? std::optional{w.nominal_current} : std::nullopt; },
          [&w](double x) { w.nominal_current = x; }});
  s.number("nominal_rise_k", w.nominal_rise, {1, 500}, "K",
           "final temperature rise of the winding at nominal_current_a");
  s.number("time_constant_s", w.time_constant, {1, 1e5}, "s", "thermal time constant of the winding");
  s.number("ambient_c", w.ambient, {-100, 200}, "C",
           "temperature of the winding without current, also at power-up: a winding that is still warm then "
           "counts as cold, for some time constants");
  s.number("warning_c", p.winding_warning, {-100, 500}, "C",
           "temperature of the winding from which on the available torque falls, to zero at trip_c");
  s.number("trip_c", p.winding_trip, {-100, 500}, "C",
           "temperature of the winding above which there is OVER_TEMPERATURE");
}

}  // namespace

void describe_protection(Section s, DriveConfig& c) {
  ProtectionSetup<>& p = c.setup.protection;
  const ProtectionLimits<>& resolved = c.drive.protection;
  s.derived("over_current_a", p.over_current, resolved.over_current, current_a, "A",
            "largest magnitude of a measured phase current; more is OVER_CURRENT");
  s.derived("dc_over_voltage_v", p.dc_over_voltage, resolved.dc_over_voltage, link_voltage_v, "V",
            "largest voltage of the DC link; more is DC_OVER_VOLTAGE");
  s.derived("over_speed_rad_s", p.over_speed, resolved.over_speed, {1e-3, 1e4}, "rad/s",
            "largest magnitude of the mechanical speed; more is OVER_SPEED");
  s.derived("dc_under_voltage_v", p.dc_under_voltage, resolved.dc_under_voltage, {0, 2e4}, "V",
            "smallest voltage of the DC link while the gates are driven; less is DC_UNDER_VOLTAGE");
  describe_ranges(s, p, resolved);
  describe_current_sensors(s, p, resolved);
  s.derived("speed_jump_rad_s", p.speed_jump, resolved.speed_jump, {1e-3, 1e4}, "rad/s",
            "largest change of the measured speed in a control period while the gates are driven; more is "
            "SPEED_SENSOR");
  s.derived("speed_error_rad_s", p.speed_error, resolved.speed_error, {1e-3, 1e4}, "rad/s",
            "largest difference of the measured speed and that by voltages and currents, beside the slip; "
            "more for speed_error_ms is SPEED_SENSOR");
  s.time("speed_error_ms", p.speed_error_ns, ns_per_ms, {0.1, 1e4}, "ms",
         "time for which the speed may differ by more than speed_error_rad_s");
  s.number("flux_lost_share", p.flux_lost_share, {0, 0.99}, "",
           "smallest estimated stator flux while flux_lost_torque_nm is exceeded, as a share of its "
           "reference; less for flux_lost_ms is FLUX_LOST; 0: never");
  s.derived("flux_lost_torque_nm", p.flux_lost_torque, resolved.flux_lost_torque, {1e-6, 1e5}, "N·m",
            "torque reference above which less flux than flux_lost_share counts as lost");
  s.time("flux_lost_ms", p.flux_lost_ns, ns_per_ms, {0.1, 1e4}, "ms",
         "time for which the flux may be below flux_lost_share");
  describe_winding(s.section("winding"), p);
  s.check(resolved);
}

}  // namespace sextant
