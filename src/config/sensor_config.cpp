#include "sextant/config/sensor_config.hpp"

#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include "common_ranges.hpp"
#include "described_table.hpp"
#include "printer.hpp"

namespace sextant {
namespace {

constexpr Range<double> gain_error{-0.99, 10};
constexpr Range<double> signed_current_a{-1e5, 1e5};
constexpr Range<double> magnitude_a{0, 1e5};
constexpr Range<double> magnitude_v{0, 2e4};
constexpr Range<std::int64_t> bits{0, 24};

void describe_phase(Section s, PhaseSensorError& p) {
  s.number("gain_error", p.gain_error, gain_error, "",
           "relative error of this phase's gain, added to that of all phases");
  s.number("offset_a", p.offset, signed_current_a, "A", "offset of this phase, added to that of all phases");
}

void describe_current(Section s, SensorParameters& p) {
  s.number("gain_error", p.current.gain_error, gain_error, "",
           "relative error of the gain of all phases' sensors");
  s.number("offset_a", p.current.offset, signed_current_a, "A", "offset of all phases' readings");
  s.number("noise_a", p.current.noise, magnitude_a, "A",
           "standard deviation of the white, normal noise of each reading");
  s.number("range_a", p.current.range, magnitude_a, "A",
           "magnitude at which readings saturate; 0: they do not");
  s.integer("bits", p.current.bits, bits, "",
            "resolution of the converter over both signs of range_a; 0: not quantised");
  describe_phase(s.section("phase_a"), p.phases[0]);
  describe_phase(s.section("phase_b"), p.phases[1]);
  describe_phase(s.section("phase_c"), p.phases[2]);
}

void describe_voltage(Section s, ConverterParameters& p) {
  s.number("gain_error", p.gain_error, gain_error, "", "relative error of the sensor's gain");
  s.number("offset_v", p.offset, {-2e4, 2e4}, "V", "offset of the reading");
  s.number("noise_v", p.noise, magnitude_v, "V",
           "standard deviation of the white, normal noise of each reading");
  s.number("range_v", p.range, magnitude_v, "V",
           "voltage at which readings saturate, also at 0; 0: they do not");
  s.integer("bits", p.bits, bits, "", "resolution of the converter over range_v; 0: not quantised");
}

/// An optional end.
void describe_end(Section& s, std::int64_t& until_ns) {
  s.add("until_s", "s", "end of the fault, counted as at_s is; not set: it stays",
        NumberField{{0, 1e6},
                    [&until_ns]() -> std::optional<double> {
                      if (until_ns == PlantFaultParameters::never_ns) return std::nullopt;
                      return double(until_ns) / ns_per_s;
                    },
                    [&until_ns](double x) { until_ns = std::llround(x * ns_per_s); }});
}

}  // namespace

void describe(Section s, SensorParameters& p, const std::function<std::int32_t()>& lead_of_drive) {
  s.integer("seed", p.seed, {0, 1'000'000'000}, "", "of the random noise: the same seed makes the same run");
  s.derived_time<std::int32_t>(
      "sampling_lead_us", p.sampling_lead_ns, 1e3, {0, 1e5}, "us",
      "time before a control period begins at which currents and link voltage are sampled; by default as the "
      "drive takes it",
      lead_of_drive);
  s.time("sampling_skew_us", p.sampling_skew_ns, 1e3, {0, 5e4}, "us",
         "time by which the current of phase b is sampled before that of c, which is sampled with the link "
         "voltage, and that of a before b; the drive takes them as of one instant; 0: they are");
  describe_current(s.section("current"), p);
  describe_voltage(s.section("voltage"), p.voltage);
  DescribedTable encoder{s.section("encoder")};
  describe(encoder, p.encoder);
  DescribedTable resolver{s.section("resolver")};
  describe(resolver, p.resolver);
  DescribedTable sin_cos{s.section("sin_cos")};
  describe(sin_cos, p.sin_cos);
  s.check(p);
}

void describe(Section s, PlantFaultParameters& p, const double& u_dc) {
  s.choice(
      "kind", p.kind,
      {{"none", PlantFaultKind::none},
       {"current_stuck", PlantFaultKind::current_stuck},
       {"current_zero", PlantFaultKind::current_zero},
       {"current_drift", PlantFaultKind::current_drift},
       {"phases_swapped", PlantFaultKind::phases_swapped},
       {power_up_fault, PlantFaultKind::cables_swapped},
       {"open_phase", PlantFaultKind::open_phase},
       {"speed_lost", PlantFaultKind::speed_lost},
       {"speed_frozen", PlantFaultKind::speed_frozen},
       {"speed_jump", PlantFaultKind::speed_jump},
       {"encoder_reversed", PlantFaultKind::encoder_reversed},
       {"link_stuck", PlantFaultKind::link_stuck},
       {"link_sag", PlantFaultKind::link_sag}},
      "a sensor's, except for those of the motor cables and the sag of the link itself, or of its source "
      "where it has a capacitance");
  s.choice("phase", p.phase, {{"a", 0}, {"b", 1}, {"c", 2}},
           "of a fault of one phase; where two are swapped: it and the next one");
  s.time(
      "at_s", p.at_ns, ns_per_s, {0, 1e6}, "s",
      "beginning of the fault: in a file as the load's profiles count, 0 from power-up on; in a request to "
      "a running plant from the request on");
  describe_end(s, p.until_ns);
  s.number("drift_a_s", p.drift, {-1e6, 1e6}, "A/s", "slope of current_drift");
  s.number("jump_rad_s", p.jump, {-1e4, 1e4}, "rad/s", "of speed_jump");
  s.derived("sag_v", p.sag_voltage, {0.5, 2e4}, "V", "voltage of link or source to which link_sag leads",
            [&u_dc] { return 0.5 * u_dc; });
  s.time("ramp_ms", p.ramp_ns, 1e6, {0, 1e6}, "ms", "time in which it does so; 0: at once");
  s.check(p);
}

std::string plant_fault_keys() {
  PlantFaultParameters fault;
  const double u_dc = SimulatedDriveIoParameters{}.u_dc;
  Schema schema;
  describe(Section{schema}, fault, u_dc);
  for (Field& field : schema.fields) {
    if (auto* choice = std::get_if<ChoiceField>(&field.kind)) std::erase(choice->names, power_up_fault);
  }
  return print_keys(schema);
}

bool is_ideal(const SimulatedDriveIoParameters& p) {
  return p.dead_time_ns == 0 && p.minimum_pulse.duration_ns == 0 && p.sensors.samples_at_once() &&
         SensorModel{p.sensors, p.fault}.is_ideal();
}

}  // namespace sextant
