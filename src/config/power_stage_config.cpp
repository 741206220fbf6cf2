#include <array>
#include <cstdio>
#include <string>

#include "drive_sections.hpp"
#include "number_text.hpp"
#include "sextant/config/drive_config.hpp"

namespace sextant {
namespace {

/// Something is wrong with saturation or iron loss, which are checked where they are described.
bool is_told(const DrivePlantParameters<double>& p) {
  return p.saturation.validate() || p.points.validate() || p.leakage.validate() || p.validate_curve() ||
         p.iron_loss.validate();
}

/// Empty where hysteresis lets the flux go, else a sentence.
std::string check_hysteresis(const DrivePlantParameters<double>& p) {
  if (p.machine.validate() || is_told(p)) return {};
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
  if (p.plant.saturates()) {
    const char* const given = p.plant.saturation.acts() ? "saturation.knee_wb above 0"
                              : p.plant.points.acts()   ? "saturation.points"
                                                        : "saturation.leakage.knee_wb above 0";
    return std::string{"integrator = \"exact\" is for machines without saturation: with "} + given + " " +
           others;
  }
  if (!p.plant.iron_loss.acts()) return {};
  return std::string{
             "integrator = \"exact\" is for machines without iron loss: with iron_loss.eddy_ohm or "
             "iron_loss.hysteresis_ohm above 0 "} +
         others;
}

/// Of main flux and leakage.
void describe_saturation(const Section& s, DrivePlantParameters<double>& p) {
  describe_parameters(s, p.saturation);
  describe_parameters(s, p.points);
  describe_parameters(s.section("leakage"), p.leakage);
  s.section("points").check([&p]() -> std::string {
    if (p.machine.validate() || p.points.validate()) return {};
    return sentence(p.validate_curve());
  });
}

void describe_inverter(Section s, SimulatedPowerStage::Parameters& p) {
  describe_gate_drivers(s, p.io);
  describe(s, p.plant.drops);
  describe_parameters(s.section_or_file("losses"), p.losses);
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

/// A fault of a contactor that there is not.
std::string check_contactor(const SimulatedPowerStage::Parameters& p) {
  if (!p.io.fault.is_of_contactor() || p.link.has_precharge()) return {};
  return "faults.kind is of the main contactor, which there is with link.precharge_ohm above 0 only";
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
    const DcLink<double> link{p.link, p.plant.machine.sigma_l_s(), p.io.u_dc, p.io.u_dc};
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

std::string check_machine(const DrivePlantParameters<double>& p) {
  if (const char* const problem = p.machine.validate()) return problem;
  if (is_told(p) || p.iron_loss.validate_with(p.largest_magnetising_inductance())) return {};
  return sentence(p.validate());
}

void describe_keys(Section s, SimulatedPowerStage::Parameters& p, const std::int32_t& lead_of_drive) {
  s.choice("integrator", p.integrator,
           {{"cvode", IntegratorKind::cvode},
            {"fixed", IntegratorKind::fixed},
            {"exact", IntegratorKind::exact},
            {"erk", IntegratorKind::erk}},
           "SUNDIALS CVODE; Runge-Kutta of fixed step; exact at frozen speed; SUNDIALS ERKStep");
  s.number("u_dc_v", p.io.u_dc,
           {"V", 1, 2e4, "voltage of the stiff DC link, or of the source of one with capacitance"});
  s.integer("hold_periods", p.io.hold_periods, "", 1, 1'000'000,
            "control periods for which a pattern holds that is not renewed");
  s.number("viscous_friction_nm_s", p.plant.viscous_friction,
           {"N·m·s/rad", 0, 1e3, "bearings and fan, torque per speed"});
  describe(s, p.plant.initial);
  describe_saturation(s.section("saturation"), p.plant);
  describe_parameters(s.section("iron_loss"), p.plant.iron_loss);
  describe_inverter(s.section("inverter"), p);
  describe_parameters(s.section("link"), p.link);
  describe_parameters(s.section("thermal"), p.thermal);
  describe_parameters(s.section("driveline"), p.driveline);
  Section sensors = s.section("sensors");
  describe(sensors, p.io.sensors, lead_of_drive);
  sensors.check(p.io.sensors);
  Section faults = s.section("faults");
  describe(faults, p.io.fault, p.io.u_dc);
  faults.check(p.io.fault);
  describe_parameters(s.section("cvode"), p.cvode);
  describe_parameters(s.section("fixed"), p.fixed);
  describe_parameters(s.section("exact"), p.exact);
  describe_parameters(s.section("erk"), p.erk);
  s.check([&p] { return check_magnetics(p); });
  s.check([&p] { return check_hysteresis(p.plant); });
  s.check([&p] { return check_initial_flux(p); });
  s.check([&p] { return check_chopper(p); });
  s.check([&p] { return check_contactor(p); });
  s.check([&p] { return check_law(p); });
  s.check([&p] { return check_stiffness(p); });
}

}  // namespace

std::string validate_free_shaft(const SimulatedPowerStage::Parameters& plant, bool imposes_speed) {
  if (!imposes_speed) return {};
  if (plant.plant.initial.speed != 0.0)
    return "an imposed speed is that of the shaft from the beginning: plant.initial_speed_rad_s must be 0, "
           "or the load a torque";
  if (!plant.driveline.acts()) return {};
  return "an imposed speed turns the motor whatever its load does: plant.driveline.inertia_kg_m2 must be 0, "
         "or the load a torque";
}

void describe_plant(const Section& root, SimulatedPowerStage::Parameters& p, LoadConfig& load,
                    const std::int32_t& lead_of_drive) {
  describe_keys(root.section("plant"), p, lead_of_drive);
  root.section("machine").check([&p] { return check_machine(p.plant); });
  root.section("plant").check(p.io);
  describe(root.section("load"), load);
  root.section("load").section("kind").check(
      [&p, &load] { return validate_free_shaft(p, load.kind == LoadConfig::Kind::imposed_speed); });
}

}  // namespace sextant
