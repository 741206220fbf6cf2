#include <cmath>
#include <optional>

#include "drive_sections.hpp"

namespace sextant {
namespace {

constexpr Range<double> sensor_current_a{1e-6, 1e9};
constexpr Range<double> voltage_v{1, 2e4};

void describe_current_sensors(Section& s, DriveConfig& c) {
  Protection<>::Parameters& p = c.drive.protection;
  const auto limits = [&c, &p] {
    return current_sensor_limits(c.control.machine, p.over_current, c.plant.io.u_dc,
                                 double(c.drive.period_ns) * 1e-9);
  };
  s.derived("current_sum_a", p.current_sum, sensor_current_a, "A",
            "largest sum of the phase currents, beside current_gain_tolerance",
            [limits] { return limits().sum; });
  s.number("current_gain_tolerance", p.current_gain_tolerance, {0, 0.99}, "",
           "of that sum, as a share of the largest phase current");
  s.derived("current_offset_a", p.current_offset, sensor_current_a, "A",
            "largest offset of a phase current's sensor: the mean reading with the gates off, of which the "
            "controller's currents are freed and which the torque monitor allows for; a larger one is "
            "CURRENT_SENSOR",
            [&c] { return limits_of(c).current_offset; });
  s.derived("current_jump_a", p.current_jump, sensor_current_a, "A",
            "largest change of a phase current that the voltage does not explain",
            [limits] { return limits().jump; });
  s.number("current_response", p.current_response, {0, 0.99}, "",
           "smallest response of a phase current to the voltage; 1: as the machine's parameters have it");
  s.derived("current_noise_a", p.current_noise, sensor_current_a, "A",
            "standard deviation of a measured current", [limits] { return limits().noise; });
  s.derived("zero_current_a", p.zero_current, sensor_current_a, "A", "reading of a phase without current",
            [limits] { return limits().zero_current; });
}

void describe_winding(Section s, Protection<>::Parameters& p) {
  WindingTemperature<>::Parameters& w = p.winding;
  s.add(
      "nominal_current_a", "A", "RMS of a phase in continuous operation; not set: no thermal model",
      NumberField{
          {1e-3, 1e5},
          [&w] { return std::isfinite(w.nominal_current) ? std::optional{w.nominal_current} : std::nullopt; },
          [&w](double x) { w.nominal_current = x; }});
  s.number("nominal_rise_k", w.nominal_rise, {1, 500}, "K", "final rise of the winding at that current");
  s.number("time_constant_s", w.time_constant, {1, 1e5}, "s", "of the winding's temperature");
  s.number("ambient_c", w.ambient, {-100, 200}, "C", "temperature without current");
  s.number("warning_c", p.winding_warning, {-100, 500}, "C", "from here on less torque is available");
  s.number("trip_c", p.winding_trip, {-100, 500}, "C", "no torque is available, and a fault");
}

}  // namespace

void describe_protection(Section s, DriveConfig& c) {
  Protection<>::Parameters& p = c.drive.protection;
  s.derived("over_current_a", p.over_current, current_a, "A", "trip level of any phase current's magnitude",
            [&c] { return limits_of(c).over_current; });
  s.derived("dc_over_voltage_v", p.dc_over_voltage, voltage_v, "V", "trip level of the DC link",
            [&c] { return limits_of(c).dc_over_voltage; });
  s.derived("over_speed_rad_s", p.over_speed, {1e-3, 1e4}, "rad/s", "trip level of the speed, both ways",
            [&c] { return limits_of(c).over_speed; });
  s.derived("dc_under_voltage_v", p.dc_under_voltage, {0, 2e4}, "V",
            "trip level of the DC link while the gates are driven",
            [&c] { return limits_of(c).dc_under_voltage; });
  describe_current_sensors(s, c);
  s.derived("speed_jump_rad_s", p.speed_jump, {1e-3, 1e4}, "rad/s",
            "largest change of the speed in a control period", [&c] { return limits_of(c).speed_jump; });
  s.derived("speed_error_rad_s", p.speed_error, {1e-3, 1e4}, "rad/s",
            "largest error of the speed against that by voltages and currents",
            [&c] { return limits_of(c).speed_error; });
  s.time("speed_error_ms", p.speed_error_ns, ns_per_ms, {0.1, 1e4}, "ms",
         "such an error for longer is a fault");
  s.number("flux_lost_share", p.flux_lost_share, {0, 0.99}, "",
           "smallest flux under torque, as a share of its reference");
  s.derived("flux_lost_torque_nm", p.flux_lost_torque, {1e-6, 1e5}, "N·m",
            "smallest torque reference that needs the flux",
            [&c] { return 0.05 * c.drive.command.torque_limit; });
  s.time("flux_lost_ms", p.flux_lost_ns, ns_per_ms, {0.1, 1e4}, "ms", "less flux for longer is a fault");
  describe_winding(s.section("winding"), p);
  s.derive([&c, &p] {
    p.machine = c.control.machine;
    p.period_ns = c.drive.period_ns;
  });
  s.check(p);
}

}  // namespace sextant
