#include "sextant/config/drive_config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "number_text.hpp"
#include "sextant/config/sensor_config.hpp"
#include "sextant/drive/drive_limits.hpp"
#include "sextant/sim/profile_table.hpp"

namespace sextant {
namespace {

constexpr double ns_per_us = 1e3;
constexpr double ns_per_ms = 1e6;
constexpr Range<double> torque_nm{-1e5, 1e5};
constexpr Range<double> torque_magnitude_nm{1e-3, 1e5};
constexpr Range<double> speed_rad_s{-1e4, 1e4};
constexpr Range<double> flux_wb{0.01, 10};
constexpr Range<double> current_a{0.1, 1e5};
constexpr Range<double> sensor_current_a{1e-6, 1e9};
constexpr Range<double> voltage_v{1, 2e4};
constexpr Range<double> tolerance{1e-14, 1e-1};

/// Default limits from machine, flux reference and link; to be called when these have been read.
DriveLimits<> limits_of(const DriveConfig& c) {
  return drive_limits(c.control.machine, c.control.flux_reference, c.plant.io.u_dc);
}

/// The flux with which the machine meets the link's linear voltage limit at the frequency of its data sheet:
/// its rated flux, where link and machine are made for each other. No number without that frequency. [Wb]
double flux_of_link(const DriveConfig& c) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double frequency_hz = c.machine.reactance_frequency_hz.value_or(none);
  return linear_voltage(c.plant.io.u_dc) / (2.0 * std::numbers::pi * frequency_hz);
}

/// What every control method shares, and the table of each.
void describe_control(Section s, DriveConfig& c) {
  std::vector<std::string> names;
  std::string meaning = "control method";
  for (const ControlMethod& method : c.methods) {
    names.push_back(method.name);
    meaning += "; " + method.name + ": " + method.meaning;
  }
  s.add("controller", "", meaning.c_str(),
        ChoiceField{std::move(names), [&c] { return c.controller; },
                    [&c](std::string_view name) { c.controller = name; }});
  s.derived(
      "flux_reference_wb", c.control.flux_reference, flux_wb, "Wb", "stator flux linkage",
      [&c] { return flux_of_link(c); },
      "the machine names no reactance_frequency_hz, or no usable flux follows from it and plant.u_dc_v");
  s.choice(
      "flux_estimator", c.control.flux_estimator,
      {{"hybrid", FluxEstimatorKind::hybrid},
       {"voltage_model", FluxEstimatorKind::voltage_model},
       {"compensated_voltage_model", FluxEstimatorKind::compensated_voltage_model},
       {"current_model", FluxEstimatorKind::current_model},
       {"observer", FluxEstimatorKind::observer},
       {"sensorless_observer", FluxEstimatorKind::sensorless_observer}},
      "voltage model at speed and current model near standstill; the paper's open integrator; that with a "
      "low-pass filter; rotor flux from current and speed; full-order observer with measured, or with "
      "estimated speed");
  s.check([&c]() -> std::string {
    if (zero_torque_speed(c.control.machine, c.control.flux_reference, c.plant.io.u_dc) > 0.0) return {};
    return "the link cannot feed flux_reference_wb even at standstill: lower it or raise plant.u_dc_v";
  });
  for (ControlMethod& method : c.methods) {
    Section table = s.section(method.name);
    method.describe(table, method.parameters, c.control);
    table.optional([&c, &method] { return c.controller == method.name; });
  }
  Section estimate = s.section("machine_estimate");
  describe(estimate, c.machine_estimate, false);
  estimate.check([&c]() -> std::string {
    const bool known = c.machine.reactance_frequency_hz || c.machine_estimate.reactance_frequency_hz;
    if (known || !c.machine_estimate.has_reactance()) return {};
    return "reactance_frequency_hz is missing, which the reactances need";
  });
}

void describe_command(Section s, DriveConfig& c) {
  CommandSupervision<>::Parameters& p = c.drive.command;
  s.derived("torque_limit_nm", p.torque_limit, torque_magnitude_nm, "N·m", "a command beyond it is blocked",
            [&c] { return limits_of(c).torque; });
  s.number("torque_rate_nm_s", p.torque_rate, {1e-3, 1e9}, "N·m/s", "largest rate of the torque reference");
  s.time("timeout_ms", p.timeout_ns, ns_per_ms, {1, 1e4}, "ms",
         "age at which the torque starts to ramp to zero");
  s.time("zero_ramp_ms", p.zero_ramp_ns, ns_per_ms, {0.01, 1e4}, "ms", "duration of that ramp");
  s.time("lost_ms", p.lost_ns, ns_per_ms, {1, 1e5}, "ms", "age at which the command counts as lost");
  s.time("status_timeout_ms", p.status_timeout_ns, ns_per_ms, {1, 1e4}, "ms",
         "age of the last status frame sent at which the same ramp starts");
  s.time("status_lost_ms", p.status_lost_ns, ns_per_ms, {1, 1e5}, "ms",
         "age of the last status frame sent that is a fault");
  s.integer("blocked_limit", p.blocked_limit, {1, 1000}, "", "blocked commands in a row that make a fault");
  s.check(p);
}

/// An optional speed of the configured curve.
void curve_speed(Section& s, const char* key, double& member, const char* meaning) {
  s.add(key, "rad/s", meaning,
        NumberField{{1e-3, 1e4},
                    [&member] { return std::isfinite(member) ? std::optional{member} : std::nullopt; },
                    [&member](double x) { member = x; }});
}

void describe_capability(Section s, DriveConfig& c) {
  TorqueCapability<>::Parameters& p = c.drive.capability;
  s.derived("torque_nm", p.torque, torque_magnitude_nm, "N·m", "largest available torque",
            [&c] { return c.drive.command.torque_limit; });
  s.number("voltage_use", p.voltage_use, {0.1, 1}, "", "share of u_dc/sqrt(3) that a torque may need");
  s.number("breakdown_use", p.breakdown_use, {0.1, 1}, "",
           "share of the breakdown torque, at the flux that the voltage allows, that may be used");
  curve_speed(s, "base_speed_rad_s", p.base_speed,
              "from it on the motoring torque falls linearly; not set: no such curve");
  curve_speed(s, "zero_torque_speed_rad_s", p.zero_torque_speed,
              "from it on there is no motoring torque; not set: no such curve");
  s.derive([&c, &p] {
    p.machine = c.control.machine;
    p.flux_reference = c.control.flux_reference;
  });
  s.check(p);
}

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

void describe_protection(Section s, DriveConfig& c) {
  Protection<>::Parameters& p = c.drive.protection;
  s.derived("over_current_a", p.over_current, current_a, "A", "trip level of any phase current's magnitude",
            [&c] { return limits_of(c).over_current; });
  s.derive([&c, &p] { c.drive.current_offset.largest = 0.02 * p.over_current; });
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

void describe_torque_monitor(Section s, DriveConfig& c) {
  TorqueMonitor<>::Parameters& p = c.drive.torque_monitor;
  constexpr Range<double> share{0, 0.95};
  constexpr Range<double> deviation_nm{1e-6, 1e9};
  s.flag("enabled", p.enabled, "torque that does not follow the command is a fault");
  s.derived("limit_nm", p.limit, deviation_nm, "N·m", "deviation of the mean torque that is one",
            [&c] { return limits_of(c).torque_deviation; });
  s.number("limit_share", p.limit_share, share, "", "the same as a share of the command; the larger counts");
  s.derived("wrong_sign_nm", p.wrong_sign, deviation_nm, "N·m",
            "mean torque against the command's sign that is a deviation", [&p] { return 0.5 * p.limit; });
  s.time("time_ms", p.time_ns, ns_per_ms, {2, 1e4}, "ms", "longest time for which a deviation lasts");
  s.number("r_s_share", p.r_s_share, share, "", "error of r_s_ohm that must not trip");
  s.number("r_r_share", p.r_r_share, share, "", "error of r_r_ohm that must not trip");
  s.number("l_m_share", p.l_m_share, share, "", "error of l_m_h that must not trip");
  s.number("sensor_share", p.sensor_share, share, "", "error of the torque by the gains of the sensors");
  s.derived("current_offset_a", p.current_offset, {0, 1e4}, "A", "offset of the currents that must not trip",
            [&c] { return limits_of(c).current_offset; });
  Section machine = s.section("machine");
  describe(machine, c.monitored_machine, false);
  machine.check([&c]() -> std::string {
    const bool known = c.machine.reactance_frequency_hz || c.monitored_machine.reactance_frequency_hz;
    if (known || !c.monitored_machine.has_reactance()) return {};
    return "reactance_frequency_hz is missing, which the reactances need";
  });
  s.derive([&c, &p] {
    p.machine =
        apply(c.monitored_machine, c.control.machine, c.machine.reactance_frequency_hz.value_or(50.0));
    p.flux_reference = c.control.flux_reference;
  });
  s.check(p);
}

void describe(Section s, ErrorControl& p) {
  s.number("relative_tolerance", p.relative_tolerance, tolerance, "", "local error of a step, of each state");
  s.number("flux_tolerance_wb", p.flux_tolerance, tolerance, "Wb", "absolute, of flux linkages");
  s.number("speed_tolerance_rad_s", p.speed_tolerance, tolerance, "rad/s", "absolute, of the speed");
  s.number("angle_tolerance_rad", p.angle_tolerance, tolerance, "rad", "absolute, of the shaft's angle");
  s.number("appended_tolerance", p.appended_tolerance, tolerance, "", "absolute, of appended states");
  s.integer("max_steps", p.max_steps, {1, 100'000'000}, "", "internal steps between two switching instants");
  s.integer("max_events", p.max_events, {1, 100'000'000}, "", "diode events between two switching instants");
  s.check(p);
}

void describe(Section s, CvodeParameters& p) {
  s.choice("method", p.method, {{"adams", CvodeMethod::adams_fixed_point}, {"bdf", CvodeMethod::bdf_newton}},
           "Adams with fixed-point iteration, or BDF with Newton's");
  describe(s, static_cast<ErrorControl&>(p));
}

/// A machine that takes too many fixed steps in a period: its run would not end in a time that makes sense.
std::string check_stiffness(const SimulatedPowerStage::Parameters& p) {
  constexpr double most_steps_a_period = 1000;
  const bool fixed = p.integrator == IntegratorKind::fixed || p.integrator == IntegratorKind::exact;
  if (!fixed || p.plant.validate() != nullptr) return {};
  const double longest_s =
      FixedStepIntegrator<SimulatedPowerStage::Plant>::longest_step(SimulatedPowerStage::Plant{p.plant});
  const double steps = double(p.io.period_ns) * 1e-9 / longest_s;
  if (steps <= most_steps_a_period) return {};
  std::array<char, 400> text{};
  std::snprintf(
      text.data(), text.size(),
      "integrator = \"%s\" would take %.3g steps of %.3g ns in a period, %g are allowed: the leakage "
      "inductances of this [machine] are too small for its resistances; integrator = \"cvode\" with "
      "cvode.method = \"bdf\" is for stiff machines",
      p.integrator == IntegratorKind::fixed ? "fixed" : "exact", steps, longest_s * 1e9, most_steps_a_period);
  return text.data();
}

}  // namespace

void describe(Section s, SimulatedPowerStage::Parameters& p) {
  s.choice("integrator", p.integrator,
           {{"cvode", IntegratorKind::cvode},
            {"fixed", IntegratorKind::fixed},
            {"exact", IntegratorKind::exact},
            {"erk", IntegratorKind::erk}},
           "SUNDIALS CVODE; Runge-Kutta of fixed step; exact at frozen speed; SUNDIALS ERKStep");
  s.number("u_dc_v", p.io.u_dc, voltage_v, "V", "stiff DC-link voltage");
  s.integer("hold_periods", p.io.hold_periods, {1, 1'000'000}, "",
            "control periods for which a pattern holds that is not renewed");
  s.number("viscous_friction_nm_s", p.plant.viscous_friction, {0, 1e3}, "N·m·s/rad",
           "bearings and fan, torque per speed");
  describe(s.section("sensors"), p.io.sensors);
  describe(s.section("faults"), p.io.fault, p.io.u_dc);
  describe(s.section("cvode"), p.cvode);
  Section fixed = s.section("fixed");
  fixed.time("max_step_us", p.fixed.max_step_ns, ns_per_us, {0.1, 1e5}, "us",
             "longest integration step; a machine that is too fast for it gets shorter ones");
  fixed.check(p.fixed);
  Section exact = s.section("exact");
  exact.time("max_step_us", p.exact.max_step_ns, ns_per_us, {0.1, 1e5}, "us",
             "longest time over which the speed is frozen, less on a light shaft; while legs are off "
             "plant.fixed counts");
  exact.check(p.exact);
  describe(s.section("erk"), p.erk);
  s.check([&p] { return check_stiffness(p); });
}

void describe(Section s, LoadConfig& p) {
  s.choice("kind", p.kind,
           {{"torque", LoadConfig::Kind::torque}, {"imposed_speed", LoadConfig::Kind::imposed_speed}},
           "a load torque, or a machine on the shaft that imposes the speed");
  describe(s.section("torque_nm"), p.torque, "N·m", torque_nm);
  describe(s.section("speed_rad_s"), p.imposed_speed, "rad/s", speed_rad_s);
  s.check(p);
}

namespace {

/// Copies values that several parts need from their one key.
void share(DriveConfig& c) {
  InductionMachineParameters<>& machine = c.plant.plant.machine;
  const double frequency_hz = c.machine.reactance_frequency_hz.value_or(50.0);
  machine = apply(c.machine, machine, frequency_hz);
  c.control.machine = apply(c.machine_estimate, machine, frequency_hz);
  c.control.period_ns = c.drive.period_ns;
  c.control.u_dc = c.plant.io.u_dc;
  c.plant.io.period_ns = c.drive.period_ns;
  c.plant.io.actuation_delay_periods = c.control.actuation_delay_periods;
}

}  // namespace

const ControlMethod& DriveConfig::method(std::string_view name) const {
  for (const ControlMethod& known : methods) {
    if (known.name == name) return known;
  }
  throw std::logic_error("there is no control method \"" + std::string{name} + "\"");
}

std::string validate_link(const DriveConfig& c) {
  const double link = c.plant.io.u_dc;
  const double trip = c.drive.protection.dc_over_voltage;
  if (!(link > trip)) return {};
  return number_text(link) + " V is above protection.dc_over_voltage_v, " + number_text(trip) +
         " V: the drive would trip at once; lower the link or raise the trip level";
}

bool is_given(const ProfileParameters& p) {
  return p.shape != ProfileShape::constant || p.value != 0.0 || !p.points.empty() || !p.table.empty();
}

std::string LoadConfig::validate() const {
  if (kind == Kind::torque && is_given(imposed_speed)) return "speed_rad_s is given, but kind is \"torque\"";
  if (kind == Kind::imposed_speed && is_given(torque))
    return "torque_nm is given, but kind is \"imposed_speed\"";
  return {};
}

MechanicalLoad::Parameters LoadConfig::parameters() const {
  if (kind == Kind::torque) return {torque, {}};
  return {{}, imposed_speed};
}

void describe(Section s, ProfileParameters& p, const char* unit, Range<double> range) {
  s.choice("shape", p.shape,
           {{"constant", ProfileShape::constant},
            {"steps", ProfileShape::steps},
            {"linear", ProfileShape::linear},
            {"sine", ProfileShape::sine},
            {"table", ProfileShape::table}},
           "one value; values held from point to point; straight lines between points; a sine; or straight "
           "lines between the rows of a file");
  s.number("value", p.value, range, unit, "of a constant; offset of a sine");
  const auto get = [&p] {
    PointsField::Pairs pairs;
    for (const ProfilePoint& point : p.points) pairs.emplace_back(point.t_s, point.value);
    return pairs;
  };
  const auto set = [&p](const PointsField::Pairs& pairs) {
    p.points.clear();
    for (const auto& [t_s, value] : pairs) p.points.push_back({t_s, value});
  };
  s.add("points", unit, "of steps and lines: times in s, the first at 0, and values",
        PointsField{{0, 1e6}, range, get, set});
  s.number("amplitude", p.amplitude, range, unit, "of a sine");
  s.number("frequency_hz", p.frequency_hz, {1e-6, 1e3}, "Hz", "of a sine");
  s.number("phase_deg", p.phase_deg, {-360, 360}, "deg", "of a sine at time zero");
  s.file("file", p.file, "time_s,value", "of a table",
         [&p, range](const std::string& path) { p.table = read_profile_table(path, range.min, range.max); });
  s.check(p);
}

void describe(Section root, DriveConfig& c) {
  describe(root.section("machine"), c.machine, true);
  root.derive([&c] { share(c); });

  describe_control(root.section("control"), c);
  describe_command(root.section("command"), c);
  describe_capability(root.section("capability"), c);
  describe_protection(root.section("protection"), c);
  describe_torque_monitor(root.section("torque_monitor"), c);
  Section drive = root.section("drive");
  drive.time("period_us", c.drive.period_ns, ns_per_us, {1, 1e5}, "us", "control period");
  drive.integer("actuation_delay_periods", c.control.actuation_delay_periods, {0, 1}, "",
                "control periods between a decision and its pattern; the controller compensates it");
  drive.flag("magnetise_first", c.drive.magnetise_first,
             "build up the flux before torque, under control.dtc.magnetising_current_a");
  // By the controller's check of its current limit the flux is ready after three rotor time constants.
  drive.derived("magnetise_timeout_ms", c.magnetise_timeout_ms, {1, 1e6}, "ms",
                "time after which flux that is not ready is a fault",
                [&c] { return std::max(1000.0, 5e3 * c.control.machine.tau_r()); });
  root.derive([&c] { c.drive.magnetise_timeout_ns = std::llround(c.magnetise_timeout_ms * ns_per_ms); });
  root.derive([&c] {
    const ControlMethod& method = c.method();
    if (!method.trims_mean_torque(method.parameters)) c.drive.reserve.tolerance = 1;
  });
  drive.derived("current_limit_a", c.drive.capability.current_limit, current_a, "A",
                "peak of the stator current vector to which the torque is limited",
                [&c] { return 0.8 * c.drive.protection.over_current; });
  Section plant = root.section("plant");
  plant.flag("measures_angle", c.plant.io.measures_angle, "the simulated measurement has the rotor's angle");
  describe(plant, c.plant);
  drive.check([&c]() -> std::string {
    // The parts' own checks run where they are described.
    const Drive<>::Parameters& p = c.drive;
    if (p.command.validate() || p.protection.validate() || p.capability.validate() ||
        p.torque_monitor.validate()) {
      return {};
    }
    if (!(p.capability.current_limit < p.protection.over_current)) {
      return "current_limit_a must be below protection.over_current_a";
    }
    const char* const problem = p.validate();
    return problem != nullptr ? problem : "";
  });
  root.section("machine").check(c.plant.plant);
  plant.check(c.plant.io);
  describe(root.section("load"), c.load);
}

}  // namespace sextant
