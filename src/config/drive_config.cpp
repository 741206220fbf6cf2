#include "sextant/config/drive_config.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "drive_sections.hpp"
#include "number_text.hpp"

namespace sextant {
namespace {

/// The basis of the drive, and the plant's part of it.
void share(DriveConfig& c) {
  InductionMachineParameters<>& machine = c.plant.plant.machine;
  DriveBasis<>& basis = c.setup.basis;
  const double frequency_hz = c.machine.reactance_frequency_hz.value_or(50.0);
  machine = apply(c.machine, machine, frequency_hz);
  basis.machine = apply(c.machine_estimate, machine, frequency_hz, c.machine_circuit());
  basis.u_dc = c.plant.io.u_dc;
  c.setup.torque_monitor.machine =
      apply(c.monitored_machine, basis.machine, frequency_hz, c.estimate_circuit());
  c.plant.io.period_ns = basis.period_ns;
  c.plant.io.actuation_delay_periods = basis.actuation_delay_periods;
}

void describe_torque_monitor(Section s, DriveConfig& c) {
  describe(s, c.setup.torque_monitor, c.drive.torque_monitor);
  Section machine = s.section("machine");
  describe_changes(machine, c.monitored_machine, c.machine, "that of the controller",
                   [&c] { return c.estimate_circuit(); });
  machine.change_at_least(Changes::when_ready);
  s.check(c.drive.torque_monitor);
}

/// The inverter as estimator, modulator and checks take it to be.
void describe_inverter(Section s, DriveConfig& c) {
  const InverterModel<>::Parameters& resolved = c.control.inverter;
  describe(s, c.setup.basis.inverter, c.setup.voltage_error, resolved);
  s.check_basis("", [&c, &resolved] { return sentence(resolved.validate(c.drive.period_ns)); });
}

/// Empty where a converter's largest reading is above its trip level, else a sentence.
std::string range_problem(const Converter& sensor, double trip, const std::string& unit, const char* key,
                          const char* fault) {
  if (!(sensor.highest() <= trip)) return {};
  return "readings end at " + rounded_text(sensor.highest()) + " " + unit + ", not above " + key + ", " +
         rounded_text(trip) + " " + unit + ": " + fault +
         " could never come; widen the range or lower the trip level";
}

/// The tighter check of the measured speed.
struct SpeedCheck {
  double limit;     ///< [rad/s]
  const char* key;  ///< its key
};

SpeedCheck speed_check(const Protection<>::Parameters& p) {
  if (p.speed_jump <= p.speed_error) return {p.speed_jump, "protection.speed_jump_rad_s"};
  return {p.speed_error, "protection.speed_error_rad_s"};
}

/// Empty where the bands of the link voltage lie between its trip levels, else a sentence.
std::string validate_bands(const DriveConfig& c) {
  const LinkVoltageBand<>::Parameters& low = c.drive.low_voltage;
  const LinkVoltageBand<>::Parameters& high = c.drive.high_voltage;
  const Protection<>::Parameters& trips = c.drive.protection;
  const auto volts = [](double u) { return rounded_text(u) + " V"; };
  if (low.is_wrong_below(trips.dc_under_voltage)) {
    return "low_voltage_zero_v, " + volts(low.zero) + ", must be from protection.dc_under_voltage_v, " +
           volts(trips.dc_under_voltage) + ", to below low_voltage_v, " +
           (low.full > 0 ? volts(low.full) : "which is not set");
  }
  if (high.is_wrong_above(trips.dc_over_voltage)) {
    return "high_voltage_zero_v, " + volts(high.zero) + ", must be from above high_voltage_v, " +
           (high.full > 0 ? volts(high.full) : "which is not set") + ", to protection.dc_over_voltage_v, " +
           volts(trips.dc_over_voltage);
  }
  if (c.setup.capability.ready_voltage &&
      !(c.drive.ready_voltage >= trips.dc_under_voltage && c.drive.ready_voltage <= c.plant.io.u_dc)) {
    return "ready_voltage_v, " + volts(c.drive.ready_voltage) +
           ", must be from protection.dc_under_voltage_v, " + volts(trips.dc_under_voltage) +
           ", to plant.u_dc_v, " + volts(c.plant.io.u_dc);
  }
  return {};
}

std::string validate_link(const DriveConfig& c) {
  const double link = c.plant.io.u_dc;
  const double trip = c.drive.protection.dc_over_voltage;
  if (!(link > trip)) return {};
  return number_text(link) + " V is above protection.dc_over_voltage_v, " + number_text(trip) +
         " V: the drive would trip at once; lower the link or raise the trip level";
}

std::string validate_initial_speed(const DriveConfig& c) {
  const double speed = std::abs(c.plant.plant.initial.speed);
  const double trip = c.drive.protection.over_speed;
  if (!(speed > trip)) return {};
  return "the shaft begins with " + number_text(speed) + " rad/s, above protection.over_speed_rad_s, " +
         number_text(trip) + " rad/s: the drive would trip; lower the speed or raise the trip level";
}

std::string validate_current_range(const DriveConfig& c) {
  const ConverterParameters& sensor = c.plant.io.sensors.current;
  if (sensor.validate() != nullptr) return {};
  return range_problem(Converter{sensor, true}, c.drive.protection.over_current, "A",
                       "protection.over_current_a", "OVER_CURRENT");
}

std::string validate_voltage_range(const DriveConfig& c) {
  const ConverterParameters& sensor = c.plant.io.sensors.voltage;
  if (sensor.validate() != nullptr) return {};
  return range_problem(Converter{sensor, false}, c.drive.protection.dc_over_voltage, "V",
                       "protection.dc_over_voltage_v", "DC_OVER_VOLTAGE");
}

std::string validate_encoder(const DriveConfig& c) {
  const EncoderParameters& encoder = c.plant.io.sensors.encoder;
  if (encoder.validate() != nullptr || encoder.lines == 0) return {};
  const double edge = 2 * std::numbers::pi / (4.0 * encoder.lines);
  const double step = edge / (encoder.window_periods * double(c.drive.period_ns) * 1e-9);
  const auto [limit, key] = speed_check(c.drive.protection);
  // A counted speed is always off by up to a step, of which half of the limit is to remain for a fault; a
  // timed one only below an edge in the window.
  const double most = encoder.speed == EncoderSpeed::count ? 0.5 * limit : limit;
  if (!(step > most)) return {};
  return number_text(encoder.lines) + " lines make steps of " + rounded_text(step) +
         " rad/s in a window of " + number_text(encoder.window_periods) + " periods, above " +
         number_text(most) + " rad/s (" + key + ", " + number_text(limit) +
         "): the drive would trip; take more lines or a longer window, or raise the limit";
}

std::string validate_resolver(const DriveConfig& c) {
  const ResolverParameters& resolver = c.plant.io.sensors.resolver;
  if (resolver.validate() != nullptr) return {};
  // Two samples differ by up to twice the error.
  const double error = resolver.quantisation_error();
  const auto [limit, key] = speed_check(c.drive.protection);
  if (!(error > 0.5 * limit)) return {};
  return number_text(resolver.bits) + " bits at " + number_text(resolver.bandwidth) +
         " Hz make errors of the speed of up to " + rounded_text(error) + " rad/s, above " +
         number_text(0.5 * limit) + " rad/s (half of " + key + ", " + number_text(limit) +
         "): the drive could trip; take more bits or a lower bandwidth, or raise the limit";
}

std::string validate_sin_cos(const DriveConfig& c) {
  const SinCosEncoderParameters& encoder = c.plant.io.sensors.sin_cos;
  if (encoder.validate() != nullptr) return {};
  // Two samples differ by up to twice the error.
  const double error = encoder.quantisation_error(double(c.drive.period_ns) * 1e-9);
  const auto [limit, key] = speed_check(c.drive.protection);
  if (!(error > 0.5 * limit)) return {};
  return number_text(encoder.bits) + " bits of " + number_text(encoder.periods) +
         " sines a revolution make errors of the speed of up to " + rounded_text(error) +
         " rad/s in a window of " + number_text(encoder.window_periods) + " periods, above " +
         number_text(0.5 * limit) + " rad/s (half of " + key + ", " + number_text(limit) +
         "): the drive could trip; take more bits, more sines or a longer window, or raise the limit";
}

}  // namespace

std::string validate_imposed_speed(const DriveConfig& c, const ProfileParameters& speed,
                                   std::int64_t duration_ns) {
  if (!speed.validate().empty()) return {};
  const double most = largest_magnitude(speed, duration_ns);
  const double trip = c.drive.protection.over_speed;
  if (!(most > trip)) return {};
  return "the speed reaches " + number_text(most) + " rad/s, above protection.over_speed_rad_s, " +
         number_text(trip) + " rad/s: the drive would trip; lower the speed or raise the trip level";
}

void check_simulated_plant(const Section& root, const DriveConfig& c, std::function<bool()> counts) {
  const auto check = [&c, counts = std::move(counts)](Section key,
                                                      std::string (*problem)(const DriveConfig&)) {
    key.check([&c, counts, problem] { return counts() ? problem(c) : std::string{}; });
  };
  const Section plant = root.section("plant");
  const Section sensors = plant.section("sensors");
  check(plant.section("u_dc_v"), validate_link);
  check(plant.section("initial_speed_rad_s"), validate_initial_speed);
  check(sensors.section("current").section("range_a"), validate_current_range);
  check(sensors.section("voltage").section("range_v"), validate_voltage_range);
  check(sensors.section("encoder").section("lines"), validate_encoder);
  check(sensors.section("resolver").section("bits"), validate_resolver);
  check(sensors.section("sin_cos").section("bits"), validate_sin_cos);
}

void describe(Section root, DriveConfig& c) {
  describe(root.section_or_file("machine"), c.machine);
  root.derive([&c] { share(c); });
  Section drive = root.section("drive");
  describe_inverter(drive.section_or_file("inverter"), c);

  describe_control(root.section("control"), c);
  describe_parameters(root.section("command"), c.setup.command, c.drive.command);
  describe_parameters(root.section("capability"), c.setup.capability, c.drive.motor.capability);
  describe_parameters(root.section("protection"), c.setup.protection, c.drive.protection);
  describe_torque_monitor(root.section("torque_monitor"), c);
  drive.time("period_us", c.setup.basis.period_ns, in_us(1, 1e5, "control period"));
  drive.integer("actuation_delay_periods", c.setup.basis.actuation_delay_periods, "", 0, 1,
                "control periods between a decision and its pattern; the controller compensates it");
  drive.time("sampling_lead_us", c.setup.basis.sampling_lead_ns,
             in_us(0, 1e5,
                   "time before a control period begins at which the power stage samples currents and link "
                   "voltage, as in the middle of a carrier period: estimate, prediction and checks count on "
                   "it"));
  drive.flag("magnetise_first", c.setup.magnetise_first,
             "build up the flux before torque, under the control method's magnetising_current_a",
             Changes::when_ready);
  drive.derived("magnetise_timeout_ms", c.setup.magnetise_timeout_ms, c.magnetise_timeout_ms,
                {"ms", 1, 1e6, "time after which flux that is not ready is a fault", Changes::when_ready});
  drive.derived("current_limit_a", c.setup.current_limit, c.drive.motor.capability.current_limit,
                {"A", 0.1, 1e5,
                 "peak of the stator current vector: limits the available torque, and what the control "
                 "method asks for",
                 Changes::always});
  describe(drive, c.setup.optimal_flux);
  describe_parameters(drive.section("anti_jerk"), c.setup.anti_jerk);
  Section plant = root.section("plant");
  plant.flag("measures_winding_temperature", c.plant.io.measures_winding_temperature,
             "the simulated measurement has the winding's temperature of plant.thermal");
  plant.section("measures_winding_temperature").check([&c]() -> std::string {
    if (!c.plant.io.measures_winding_temperature || c.plant.thermal.acts()) return {};
    return "the temperature of the winding is not known without plant.thermal.winding_j_per_k and the others";
  });
  plant.flag("measures_angle", c.plant.io.measures_angle, "the simulated measurement has the rotor's angle");
  describe_plant(root, c.plant, c.load, c.drive.sampling_lead_ns);
  drive.check([&c]() -> std::string {
    // The parts' own checks run where they are described.
    const Drive<>::Parameters& p = c.drive;
    if (p.command.validate() || p.protection.validate() || p.motor.capability.validate() ||
        p.validate_bands() || p.torque_monitor.validate() || p.anti_jerk.validate()) {
      return {};
    }
    if (!(p.motor.capability.current_limit < p.protection.over_current)) {
      return "current_limit_a must be below protection.over_current_a";
    }
    return sentence(p.validate());
  });
  root.section("capability").check([&c]() -> std::string {
    if (!(c.drive.motor.capability.voltage_use > 1) || c.method().make()->reaches_six_step()) return {};
    return "voltage_use above 1 needs a modulated method with overmodulation \"fundamental\", which \"" +
           c.controller + "\" is not: choose one, or voltage_use of 1 at most";
  });
  root.section("capability").check([&c] { return validate_bands(c); });
}

}  // namespace sextant
