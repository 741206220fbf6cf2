#include <array>
#include <cstdio>
#include <iterator>
#include <string>

#include "common_ranges.hpp"
#include "described_table.hpp"
#include "number_text.hpp"
#include "sextant/config/drive_config.hpp"
#include "sextant/config/inverter_loss_config.hpp"
#include "sextant/config/sensor_config.hpp"

namespace sextant {
namespace {

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
  s.choice("law", p.io.law, {{"switched", InverterLaw::switched}, {"averaged", InverterLaw::averaged}},
           "the machine gets each edge of the legs, or the mean of what they do over a control period, which "
           "is faster and has no ripple");
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
           {std::begin(short_pulses_choices), std::end(short_pulses_choices)},
           "a command shorter than minimum_pulse_us does not act, and each edge acts minimum_pulse_us late, "
           "as after a driver's input filter; or it acts for that long, and other edges at once");
  s.number("threshold_v", p.plant.drops.threshold_voltage, {0, 1e3}, "V",
           "voltage of a switch or diode that conducts, without current; cvode and erk then stop at each "
           "switching and at each zero of a current, fixed in periods in which a current changes its sign, "
           "and exact is fixed; the drive knows of it by drive.inverter.threshold_v; 0: none");
  s.number("slope_ohm", p.plant.drops.slope_resistance, {0, 1e3}, "ohm",
           "by which the voltage of a conducting switch or diode rises with its current; the drive knows of "
           "it by drive.inverter.slope_ohm; 0: none");
  describe(s.section("losses"), p.losses);
}

/// A flux that the link cannot make ends the run.
std::string check_initial_flux(const SimulatedPowerStage::Parameters& p) {
  if (p.plant.validate() != nullptr || p.plant.initial.rotor_flux == 0.0) return {};
  SimulatedPowerStage::Plant plant{p.plant};
  plant.set_inputs({.u_dc = p.io.u_dc});
  if (plant.is_reachable()) return {};
  return "initial_flux_wb is more than this [machine] can have behind a link of u_dc_v, " +
         number_text(p.io.u_dc) + " V: lower it";
}

/// Losses of edges that there are not.
std::string check_law(const SimulatedPowerStage::Parameters& p) {
  if (p.io.law == InverterLaw::switched || !p.losses.acts()) return {};
  return "inverter.law must be \"switched\": inverter.losses are those of each edge of the legs, which the "
         "averaged law does not have";
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
  DescribedTable own{s};
  describe(own, p.plant.initial);
  describe_parameters(s.section("saturation"), p.plant.saturation);
  describe_parameters(s.section("iron_loss"), p.plant.iron_loss);
  describe_inverter(s.section("inverter"), p);
  describe_parameters(s.section("link"), p.link);
  describe_parameters(s.section("thermal"), p.thermal);
  describe_parameters(s.section("driveline"), p.driveline);
  describe(s.section("sensors"), p.io.sensors, lead_of_drive);
  describe(s.section("faults"), p.io.fault, p.io.u_dc);
  describe_parameters(s.section("cvode"), p.cvode);
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
  describe_parameters(s.section("erk"), p.erk);
  s.check([&p] { return check_magnetics(p); });
  s.check([&p] { return check_hysteresis(p.plant); });
  s.check([&p] { return check_initial_flux(p); });
  s.check([&p] { return check_chopper(p); });
  s.check([&p] { return check_law(p); });
  s.check([&p] { return check_stiffness(p); });
}

}  // namespace sextant
