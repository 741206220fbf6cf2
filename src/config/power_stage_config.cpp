#include <array>
#include <cstdio>
#include <string>

#include "common_ranges.hpp"
#include "number_text.hpp"
#include "sextant/config/drive_config.hpp"
#include "sextant/config/sensor_config.hpp"

namespace sextant {
namespace {

constexpr double ns_per_us = 1e3;
constexpr Range<double> tolerance{1e-14, 1e-1};

void describe(Section s, ErrorControl& p) {
  s.choice("at_switching", p.at_switching,
           {{"by_tolerance", AtSwitching::by_tolerance},
            {"go_on", AtSwitching::go_on},
            {"stop", AtSwitching::stop}},
           "where the inverter switches with every leg driven: go on, restart, or restart where the relative "
           "tolerance is below 1e-7");
  s.number("relative_tolerance", p.relative_tolerance, tolerance, "",
           "local error of a step, of each state; 1e-7 where it goes on, 1e-11 where it restarts");
  s.number("flux_tolerance_wb", p.flux_tolerance, tolerance, "Wb",
           "absolute, of flux linkages; 0.01 Wb times the relative one where it goes on, else 1e-13 Wb");
  s.number("speed_tolerance_rad_s", p.speed_tolerance, tolerance, "rad/s",
           "absolute, of the speed; 1000 rad/s times the relative one where it goes on, else 1e-11 rad/s");
  s.number(
      "angle_tolerance_rad", p.angle_tolerance, tolerance, "rad",
      "absolute, of the shaft's angle; 1000 rad times the relative one where it goes on, else 1e-11 rad");
  s.number("appended_tolerance", p.appended_tolerance, tolerance, "", "absolute, of appended states; 1e-9");
  s.integer("max_steps", p.max_steps, {1, 100'000'000}, "", "internal steps between two switching instants");
  s.integer("max_events", p.max_events, {1, 100'000'000}, "", "diode events between two switching instants");
  s.check(p);
}

void describe(Section s, CvodeParameters& p) {
  s.choice("method", p.method, {{"adams", CvodeMethod::adams_fixed_point}, {"bdf", CvodeMethod::bdf_newton}},
           "Adams with fixed-point iteration, or BDF with Newton's");
  describe(s, static_cast<ErrorControl&>(p));
}

void describe(Section s, SaturationParameters<double>& p) {
  constexpr Range<double> flux_wb{0, 1e3};
  s.number(
      "knee_wb", p.knee, flux_wb, "Wb",
      "stator flux linkage at which the machine's stator inductance L_ls + L_m has fallen to half of what it "
      "is at small fluxes: L_su/(1 + (psi_s/knee_wb)^exponent); all other elements of the Γ circuit are "
      "constant; 0: it does not saturate");
  s.integer("exponent", p.exponent,
            {SaturationParameters<>::smallest_exponent, SaturationParameters<>::largest_exponent}, "",
            "of the same, how sharp the knee is; counts where knee_wb is not 0");
  s.number("machine_flux_wb", p.machine_flux, flux_wb, "Wb",
           "stator flux linkage at which the stator inductance is that of [machine], as that of a no-load "
           "test is at rated voltage; 0: [machine] holds for small fluxes; counts where knee_wb is not 0");
  s.check(p);
}

void describe(Section s, IronLossParameters<double>& p) {
  constexpr Range<double> ohm{0, 1e9};
  s.number("eddy_ohm", p.eddy_resistance, ohm, "ohm",
           "resistance per phase of the eddy currents in the iron, across the voltage that the rotor flux "
           "linkage induces, beside the magnetising inductance of the inverse-Γ circuit: a loss by frequency "
           "squared; of the machine alone: the drive's drive.iron_loss_resistance_ohm is a resistance at all "
           "frequencies, for flux_optimum = \"min_loss\" only, and no estimator knows of either; 0: none");
  s.number("hysteresis_ohm", p.hysteresis_resistance, ohm, "ohm",
           "the same of hysteresis, at the frequency at_rad_s and in proportion to the frequency: a loss by "
           "frequency; above the magnetising reactance there; 0: none");
  s.number(
      "at_rad_s", p.hysteresis_frequency, {1e-3, 1e6}, "rad/s",
      "electrical angular frequency at which hysteresis_ohm holds; counts where hysteresis_ohm is not 0");
  s.check(p);
}

/// Empty where hysteresis lets the flux go, else a sentence.
std::string check_hysteresis(const DrivePlantParameters<double>& p) {
  if (p.machine.validate() != nullptr || p.saturation.validate() != nullptr ||
      p.iron_loss.validate() != nullptr) {
    return {};
  }
  const double least = p.iron_loss.hysteresis_frequency * p.largest_magnetising_inductance();
  if (p.iron_loss.validate_with(p.largest_magnetising_inductance()) == nullptr) return {};
  return "iron_loss.hysteresis_ohm must be above " + rounded_text(least) +
         " ohm, the magnetising reactance of this [machine] at iron_loss.at_rad_s, or hysteresis would hold "
         "the flux without a current";
}

void describe(Section s, DcLinkParameters<double>& p) {
  constexpr Range<double> resistance_ohm{0, 1e6};
  s.number("capacitance_f", p.capacitance, {0, 1e3}, "F",
           "of the DC link, whose voltage is then a state that begins at u_dc_v; integrators stop at each "
           "switching, and exact is fixed; 0: the link is stiff");
  s.number("source_ohm", p.source_resistance, resistance_ohm, "ohm",
           "in series with the source of u_dc_v; above 0 where capacitance_f is not 0");
  s.number("source_h", p.source_inductance, {0, 1e3}, "H", "the same, inductance; 0: none");
  s.flag("source_diode", p.source_diode, "the source is a rectifier, which takes no current back");
  s.number("chopper_ohm", p.chopper_resistance, resistance_ohm, "ohm",
           "resistor that the brake chopper puts across the link; 0: no chopper");
  s.number("chopper_on_v", p.chopper_on, {0, 1e5}, "V", "link voltage at which the brake chopper turns on");
  s.number("chopper_off_v", p.chopper_off, {0, 1e5}, "V",
           "link voltage at which it turns off, between u_dc_v and chopper_on_v");
  s.check(p);
}

void describe_nodes(Section s, ThermalNodes<double>& x, const char* suffix, Range<double> range,
                    const char* unit, const char* winding, const char* rotor, const char* housing) {
  s.number(std::string{"winding"} + suffix, x.winding, range, unit, winding);
  s.number(std::string{"rotor"} + suffix, x.rotor, range, unit, rotor);
  s.number(std::string{"housing"} + suffix, x.housing, range, unit, housing);
}

void describe(Section s, ThermalParameters<double>& p) {
  constexpr Range<double> w_per_k{0, 1e6};
  constexpr Range<double> temperature_c{-100, 400};
  constexpr Range<double> per_k{0, 0.02};
  describe_nodes(s, p.capacity, "_j_per_k", {0, 1e9}, "J/K",
                 "heat capacity of the stator winding, which its copper loss heats; 0, as those of rotor and "
                 "housing: no thermal network, temperatures are unknown and resistances constant",
                 "the same of the rotor with its iron, which the loss in its resistance heats",
                 "the same of the housing with the stator's iron, which iron loss and viscous friction heat");
  s.number("winding_to_rotor_w_per_k", p.winding_to_rotor, w_per_k, "W/K",
           "thermal conductance across the air gap");
  s.number("winding_to_housing_w_per_k", p.winding_to_housing, w_per_k, "W/K",
           "the same from the winding through the stator's iron");
  s.number("rotor_to_housing_w_per_k", p.rotor_to_housing, w_per_k, "W/K",
           "the same from the rotor through bearings and inner air");
  describe_nodes(s, p.to_ambient, "_to_ambient_w_per_k", w_per_k, "W/K",
                 "the same from the winding to the ambient; each node needs a way to the ambient",
                 "the same from the rotor, as of a ventilated machine",
                 "the same from the housing, by surface and fan");
  s.number("ambient_c", p.ambient, temperature_c, "C", "temperature of the ambient");
  s.number("winding_c", p.start.winding, temperature_c, "C",
           "temperature of the winding at the beginning; not set: ambient_c");
  s.number("rotor_c", p.start.rotor, temperature_c, "C", "the same of the rotor");
  s.number("housing_c", p.start.housing, temperature_c, "C", "the same of the housing");
  s.number("reference_c", p.reference, temperature_c, "C",
           "temperature at which the resistances of [machine] hold; the drive goes on to believe in those");
  s.number("winding_per_k", p.winding_coefficient, per_k, "1/K",
           "by which R_s rises, of what it is at reference_c: 0.00393 for copper at 20 °C");
  s.number("rotor_per_k", p.rotor_coefficient, per_k, "1/K",
           "the same of R_r: 0.00403 for aluminium, 0.00393 for copper at 20 °C");
  s.time("step_ms", p.step_ns, 1e6, {1e-3, 1e3}, "ms",
         "time after which temperatures and resistances move, at the beginning of a control period; they lag "
         "by half of it; at most a tenth of the shortest time constant");
  s.check(p);
}

void describe(Section s, DrivelineParameters<double>& p) {
  s.number("inertia_kg_m2", p.inertia, {0, 1e6}, "kg·m²",
           "of the load behind a shaft that twists, on which the load torque and a vehicle's road load and "
           "mass then act in place of the motor's shaft; this table is of the load's side of the gear; "
           "integrators stop at each switching, and exact is fixed; 0: the load is on the motor's shaft");
  s.number("stiffness_nm_rad", p.stiffness, {0, 1e9}, "N·m/rad",
           "of the shaft, torque by its twist; above 0 where inertia_kg_m2 is not 0");
  s.number("damping_nm_s_rad", p.damping, {0, 1e6}, "N·m·s/rad",
           "of the shaft, torque by the rate of its twist");
  s.number("backlash_rad", p.backlash, {0, 10}, "rad",
           "full gap from one contact of the shaft to the other; a contact only pushes; 0: none");
  s.number("gear_ratio", p.gear_ratio, {1e-3, 1e3}, "",
           "speed of the motor by that of the load: at the motor inertia, stiffness and damping count by its "
           "square, the load torque by it, and angles times it");
  s.check(p);
}

/// An integrator that cannot move the machine.
std::string check_magnetics(const SimulatedPowerStage::Parameters& p) {
  if (p.integrator != IntegratorKind::exact) return {};
  const char* const others = "it must be \"cvode\", \"erk\" or \"fixed\"";
  if (p.plant.saturation.acts()) {
    return std::string{
               "integrator = \"exact\" is for machines without saturation: with saturation.knee_wb "
               "above 0 "} +
           others;
  }
  if (!p.plant.iron_loss.acts()) return {};
  return std::string{
             "integrator = \"exact\" is for machines without iron loss: with iron_loss.eddy_ohm or "
             "iron_loss.hysteresis_ohm above 0 "} +
         others;
}

void describe_inverter(Section s, SimulatedPowerStage::Parameters& p) {
  s.time("dead_time_us", p.io.dead_time_ns, ns_per_us, {0, 5e4}, "us",
         "time for which both switches of a leg are off where it changes between low and high, while its "
         "diodes carry the current; the drive reads the commanded edges, and knows of it by "
         "drive.inverter.dead_time_us; 0: none");
  s.time(
      "minimum_pulse_us", p.io.minimum_pulse.duration_ns, ns_per_us, {0, 5e4}, "us",
      "shortest time for which a leg stays high or low, before its dead time, as the gate drivers keep it: "
      "from the dead time to below half of the control period; short_pulses says what becomes of a "
      "shorter command, which the run counts; 0: none");
  s.choice("short_pulses", p.io.minimum_pulse.short_pulses,
           {{"dropped", ShortPulses::dropped}, {"stretched", ShortPulses::stretched}},
           "a command shorter than minimum_pulse_us does not act, and each edge acts minimum_pulse_us late, "
           "as after a driver's input filter; or it acts for that long, and other edges at once");
  s.number("threshold_v", p.plant.drops.threshold_voltage, {0, 1e3}, "V",
           "voltage of a switch or diode that conducts, without current; the integrators then stop at each "
           "switching and at each zero of a current, and exact is fixed; the drive knows of it by "
           "drive.inverter.threshold_v; 0: none");
  s.number("slope_ohm", p.plant.drops.slope_resistance, {0, 1e3}, "ohm",
           "by which the voltage of a conducting switch or diode rises with its current; the drive knows of "
           "it by drive.inverter.slope_ohm; 0: none");
}

/// A brake chopper that would load the source.
std::string check_chopper(const SimulatedPowerStage::Parameters& p) {
  if (!p.link.has_chopper() || p.link.chopper_off > p.io.u_dc) return {};
  return "link.chopper_off_v must be above u_dc_v, or the brake chopper loads the source";
}

/// Why a plant takes more steps of the fixed integrator in a period than its run would end with in a time
/// that makes sense; empty where it does not. cause: what is too fast; what: it, where it is stiff.
template <class Plant>
std::string check_steps(const SimulatedPowerStage::Parameters& p, const Plant& plant, const char* cause,
                        const char* what) {
  constexpr double most_steps_a_period = 1000;
  const double longest_s = FixedStepIntegrator<Plant>::longest_step(plant);
  const double steps = double(p.io.period_ns) * 1e-9 / longest_s;
  if (steps <= most_steps_a_period) return {};
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(),
                "integrator = \"%s\" would take %.3g steps of %.3g ns in a period, %g are allowed: %s; "
                "integrator = \"cvode\" with cvode.method = \"bdf\" is for stiff %s",
                p.integrator == IntegratorKind::fixed ? "fixed" : "exact", steps, longest_s * 1e9,
                most_steps_a_period, cause, what);
  return text.data();
}

std::string check_stiffness(const SimulatedPowerStage::Parameters& p) {
  const bool fixed = p.integrator == IntegratorKind::fixed || p.integrator == IntegratorKind::exact;
  if (!fixed || p.plant.validate() != nullptr || p.link.validate() != nullptr ||
      p.driveline.validate() != nullptr) {
    return {};
  }
  std::string problem =
      check_steps(p, SimulatedPowerStage::Plant{p.plant},
                  "the leakage inductances of this [machine] are too small for its resistances", "machines");
  if (problem.empty() && p.link.acts()) {
    const DcLink<double> link{p.link, p.plant.machine.sigma_l_s(), p.io.u_dc};
    problem = check_steps(p, LinkedPowerStage::Plant{p.plant, link},
                          "capacitance, resistances or inductance of [plant.link] are too small", "links");
  }
  if (!problem.empty() || !p.driveline.acts()) return problem;
  using Shaft = Driveline<double>;
  const Shaft shaft{p.driveline, p.plant.machine.inertia, p.plant.viscous_friction, p.plant.road_load};
  return check_steps(p, PowerStageOf<Shaft>::Plant{p.plant, shaft},
                     "stiffness or damping of [plant.driveline] are too large for its inertia or the motor's",
                     "drivelines");
}

}  // namespace

void describe(Section s, SimulatedPowerStage::Parameters& p,
              const std::function<std::int32_t()>& lead_of_drive) {
  s.choice("integrator", p.integrator,
           {{"cvode", IntegratorKind::cvode},
            {"fixed", IntegratorKind::fixed},
            {"exact", IntegratorKind::exact},
            {"erk", IntegratorKind::erk}},
           "SUNDIALS CVODE; Runge-Kutta of fixed step; exact at frozen speed; SUNDIALS ERKStep");
  s.number("u_dc_v", p.io.u_dc, link_voltage_v, "V",
           "voltage of the stiff DC link, or of the source of one with capacitance");
  s.integer("hold_periods", p.io.hold_periods, {1, 1'000'000}, "",
            "control periods for which a pattern holds that is not renewed");
  s.number("viscous_friction_nm_s", p.plant.viscous_friction, {0, 1e3}, "N·m·s/rad",
           "bearings and fan, torque per speed");
  describe(s.section("saturation"), p.plant.saturation);
  describe(s.section("iron_loss"), p.plant.iron_loss);
  describe_inverter(s.section("inverter"), p);
  describe(s.section("link"), p.link);
  describe(s.section("thermal"), p.thermal);
  describe(s.section("driveline"), p.driveline);
  describe(s.section("sensors"), p.io.sensors, lead_of_drive);
  describe(s.section("faults"), p.io.fault, p.io.u_dc);
  describe(s.section("cvode"), p.cvode);
  Section fixed = s.section("fixed");
  fixed.time("max_step_us", p.fixed.max_step_ns, ns_per_us, {0.1, 1e5}, "us",
             "longest integration step; a machine that is too fast for it gets shorter ones");
  fixed.choice("at_switching", p.fixed.at_switching,
               {{"go_on", AtSwitching::go_on}, {"stop", AtSwitching::stop}},
               "where the inverter switches with every leg driven: go on, or end a step");
  fixed.check(p.fixed);
  Section exact = s.section("exact");
  exact.time("max_step_us", p.exact.max_step_ns, ns_per_us, {0.1, 1e5}, "us",
             "longest time over which the speed is frozen, less on a light shaft; while legs are off "
             "plant.fixed counts");
  exact.check(p.exact);
  describe(s.section("erk"), p.erk);
  s.check([&p] { return check_magnetics(p); });
  s.check([&p] { return check_hysteresis(p.plant); });
  s.check([&p] { return check_chopper(p); });
  s.check([&p] { return check_stiffness(p); });
}

}  // namespace sextant
