#include "sextant/config/drive_config.hpp"

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
constexpr Range<double> voltage_v{1, 2e4};
constexpr Range<double> tolerance{1e-14, 1e-1};

void describe(Section s, TorqueComparator<>::Parameters& p) {
  s.number("torque_band_upper_nm", p.upper_band, torque_magnitude_nm, "N·m",
           "band of the upper torque relay");
  s.number("torque_band_lower_nm", p.lower_band, torque_magnitude_nm, "N·m",
           "band of the lower torque relay, as a magnitude");
  s.choice("comparator_reading", p.reading,
           {{"relay", ComparatorReading::relay}, {"memoryless", ComparatorReading::memoryless}},
           "torque relays with memory, or the band alone");
}

void describe(Section s, DirectTorqueController<>::Parameters& p) {
  s.time("period_us", p.period_ns, ns_per_us, {1, 1e5}, "us", "control period");
  s.number("flux_reference_wb", p.flux_reference, flux_wb, "Wb", "stator flux linkage");
  describe(s, p.torque_comparator);
  s.number("flux_band_wb", p.flux_comparator.band, {1e-6, 1}, "Wb", "half the width of the flux hysteresis");
  s.number("sector_start_deg", p.sector.sector_start_deg, {-180, 180}, "deg",
           "lower edge of sector 1, from voltage vector 1");
  s.number("magnetising_current_a", p.magnetiser.current_limit, current_a, "A",
           "limit while the flux is built up at standstill");
  s.number("hand_over_current_a", p.magnetiser.hand_over_current, current_a, "A",
           "largest current at which torque control takes over from magnetising");
  s.check(p);
}

void describe(Section s, CommandGate<>::Parameters& p) {
  s.number("torque_limit_nm", p.torque_limit, torque_magnitude_nm, "N·m", "a command beyond it is blocked");
  s.number("torque_rate_nm_s", p.torque_rate, {1e-3, 1e9}, "N·m/s", "largest rate of the admitted torque");
  s.time("timeout_ms", p.timeout_ns, ns_per_ms, {1, 1e4}, "ms",
         "age at which the torque starts to ramp to zero");
  s.time("zero_ramp_ms", p.zero_ramp_ns, ns_per_ms, {0.01, 1e4}, "ms", "duration of that ramp");
  s.time("lost_ms", p.lost_ns, ns_per_ms, {1, 1e5}, "ms", "age at which the command counts as lost");
  s.integer("blocked_limit", p.blocked_limit, {1, 1000}, "", "blocked commands in a row that make a fault");
  s.check(p);
}

void describe(Section s, TorqueCapability<>::Parameters& p) {
  s.number("torque_nm", p.torque, torque_magnitude_nm, "N·m", "available up to the base speed");
  s.number("base_speed_rad_s", p.base_speed, {1e-3, 1e4}, "rad/s", "up to it all torque is available");
  s.number("zero_torque_speed_rad_s", p.zero_torque_speed, {1e-3, 1e4}, "rad/s",
           "at it no motoring torque is left");
  s.check(p);
}

void describe(Section s, Protection<>::Parameters& p) {
  s.number("over_current_a", p.over_current, current_a, "A", "trip level of any phase current's magnitude");
  s.number("dc_over_voltage_v", p.dc_over_voltage, voltage_v, "V", "trip level of the DC link");
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

}  // namespace

void describe(Section s, SimulatedPowerStage::Parameters& p) {
  s.choice("integrator", p.integrator,
           {{"cvode", IntegratorKind::cvode},
            {"fixed", IntegratorKind::fixed},
            {"exact", IntegratorKind::exact},
            {"erk", IntegratorKind::erk}},
           "SUNDIALS CVODE; Runge-Kutta of fixed step; exact at frozen speed; SUNDIALS ERKStep");
  s.number("u_dc_v", p.io.u_dc, voltage_v, "V", "stiff DC-link voltage");
  s.integer("actuation_delay_periods", p.io.actuation_delay_periods, {0, 1}, "",
            "control periods between a decision and its pattern; the controller compensates it");
  s.integer("hold_periods", p.io.hold_periods, {1, 1'000'000}, "",
            "control periods for which a pattern holds that is not renewed");
  s.number("viscous_friction_nm_s", p.plant.viscous_friction, {0, 1e3}, "N·m·s/rad",
           "bearings and fan, torque per speed");
  describe(s.section("cvode"), p.cvode);
  Section fixed = s.section("fixed");
  fixed.time("max_step_us", p.fixed.max_step_ns, ns_per_us, {0.1, 1e5}, "us", "longest integration step");
  fixed.check(p.fixed);
  Section exact = s.section("exact");
  exact.time("max_step_us", p.exact.max_step_ns, ns_per_us, {0.1, 1e5}, "us",
             "longest time over which the speed is frozen; while legs are off plant.fixed counts");
  exact.check(p.exact);
  describe(s.section("erk"), p.erk);
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

/// What stands in the file once and is needed by several.
void share(DriveConfig& c) {
  InductionMachineParameters<>& machine = c.plant.plant.machine;
  const double frequency_hz = c.machine.reactance_frequency_hz.value_or(50.0);
  machine = apply(c.machine, machine, frequency_hz);
  c.direct_torque.machine = apply(c.machine_estimate, machine, frequency_hz);
  c.direct_torque.actuation_delay_periods = c.plant.io.actuation_delay_periods;
  c.drive.period_ns = c.direct_torque.period_ns;
  c.plant.io.period_ns = c.direct_torque.period_ns;
}

}  // namespace

bool is_said(const ProfileParameters& p) {
  return p.shape != ProfileShape::constant || p.value != 0.0 || !p.points.empty() || !p.table.empty();
}

std::string LoadConfig::validate() const {
  if (kind == Kind::torque && is_said(imposed_speed)) return "speed_rad_s is given, but kind is \"torque\"";
  if (kind == Kind::imposed_speed && is_said(torque))
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

  Section control = root.section("control");
  control.choice("controller", c.controller, {{"dtc", ControllerKind::direct_torque}},
                 "direct torque control");
  describe(control, c.direct_torque);
  Section estimate = control.section("machine_estimate");
  describe(estimate, c.machine_estimate, false);
  estimate.check([&c]() -> std::string {
    const bool known = c.machine.reactance_frequency_hz || c.machine_estimate.reactance_frequency_hz;
    if (known || !c.machine_estimate.has_reactance()) return {};
    return "reactance_frequency_hz is missing, which the reactances need";
  });

  Section drive = root.section("drive");
  drive.flag("magnetise_first", c.drive.magnetise_first, "build up the flux at standstill before torque");
  drive.number("magnetise_below_speed_rad_s", c.drive.magnetise_below_speed, {0, 1e3}, "rad/s",
               "a faster machine starts without magnetising first");
  describe(root.section("gate"), c.drive.gate);
  describe(root.section("capability"), c.drive.capability);
  describe(root.section("protection"), c.drive.protection);
  describe(root.section("plant"), c.plant);
  drive.check([&c]() -> std::string {
    // What its parts have to say is said where they are described.
    const Drive<>::Parameters& p = c.drive;
    if (p.gate.validate() || p.protection.validate() || p.capability.validate()) return {};
    const char* const problem = p.validate();
    return problem != nullptr ? problem : "";
  });
  root.section("machine").check(c.plant.plant);
  root.section("plant").check(c.plant.io);
  describe(root.section("load"), c.load);
}

}  // namespace sextant
