// The torque of one machine over a switching sequence, by each integrator of the simulated power stage at its
// defaults; of a machine that saturates or has iron loss without the exact one. With a DC link of its own
// also the link's voltage, behind a driveline also the torque of its shaft, with a thermal network also the
// temperatures at the end. Standard input and output are one JSON object each; see
// tests/python/test_trajectories.py.

#include <cstdint>
#include <cstdio>
#include <iostream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

InductionMachineParameters<> machine_of(const nlohmann::json& j) {
  return {.r_s = j.at("r_s"),
          .r_r = j.at("r_r"),
          .l_ls = j.at("l_ls"),
          .l_lr = j.at("l_lr"),
          .l_m = j.at("l_m"),
          .pole_pairs = j.at("pole_pairs"),
          .inertia = j.at("inertia")};
}

/// None where the task does not name one.
SaturationParameters<> saturation_of(const nlohmann::json& task) {
  if (!task.contains("saturation")) return {};
  const nlohmann::json& j = task.at("saturation");
  return {.knee = j.at("knee"), .exponent = j.at("exponent"), .machine_flux = j.at("machine_flux")};
}

/// None where the task does not name some.
MagnetisingPoints<> points_of(const nlohmann::json& task) {
  MagnetisingPoints<> of;
  if (task.contains("points")) of.points = task.at("points").get<std::vector<std::pair<double, double>>>();
  return of;
}

/// None where the task does not name one.
LeakageSaturation<> leakage_of(const nlohmann::json& task) {
  if (!task.contains("leakage")) return {};
  const nlohmann::json& j = task.at("leakage");
  return {.knee = j.at("knee"), .exponent = j.at("exponent")};
}

/// None where the task does not name one.
IronLossParameters<> iron_loss_of(const nlohmann::json& task) {
  if (!task.contains("iron_loss")) return {};
  const nlohmann::json& j = task.at("iron_loss");
  return {.eddy_resistance = j.at("eddy"),
          .hysteresis_resistance = j.at("hysteresis"),
          .hysteresis_frequency = j.at("frequency")};
}

/// Stiff where the task does not name one.
DcLinkParameters<> link_of(const nlohmann::json& task) {
  if (!task.contains("link")) return {};
  const nlohmann::json& j = task.at("link");
  return {.capacitance = j.at("capacitance"),
          .source_resistance = j.at("source_resistance"),
          .source_inductance = j.at("source_inductance"),
          .source_diode = j.at("source_diode"),
          .chopper_resistance = j.at("chopper_resistance"),
          .chopper_on = j.at("chopper_on"),
          .chopper_off = j.at("chopper_off")};
}

ThermalNodes<double> nodes_of(const nlohmann::json& j) {
  return {j.at(0), j.at(1), j.at(2)};
}

/// None where the task does not name one.
ThermalParameters<> thermal_of(const nlohmann::json& task) {
  if (!task.contains("thermal")) return {};
  const nlohmann::json& j = task.at("thermal");
  const ThermalNodes<double> between = nodes_of(j.at("between"));
  ThermalParameters<> thermal;
  thermal.capacity = nodes_of(j.at("capacity"));
  thermal.winding_to_rotor = between.winding;
  thermal.winding_to_housing = between.rotor;
  thermal.rotor_to_housing = between.housing;
  thermal.to_ambient = nodes_of(j.at("to_ambient"));
  thermal.ambient = j.at("ambient");
  thermal.step_ns = j.at("step_ns");
  return thermal;
}

/// None where the task does not name one.
DrivelineParameters<> driveline_of(const nlohmann::json& task) {
  if (!task.contains("driveline")) return {};
  const nlohmann::json& j = task.at("driveline");
  return {.inertia = j.at("inertia"),
          .stiffness = j.at("stiffness"),
          .damping = j.at("damping"),
          .backlash = j.at("backlash"),
          .gear_ratio = j.at("gear_ratio")};
}

/// Torque of machine and shaft [N·m] and link voltage [V] at the end of each period; shorter than the
/// sequence where the power stage has failed. Temperatures of winding, rotor and housing at the end. [°C]
struct Course {
  std::vector<double> tau_e{};
  std::vector<double> shaft{};
  std::vector<double> u_dc{};
  std::vector<double> temperatures{};
};

SimulatedPowerStageParameters parameters_of(const nlohmann::json& task, IntegratorKind integrator,
                                            AtSwitching at_switching) {
  SimulatedPowerStageParameters parameters;
  parameters.integrator = integrator;
  parameters.cvode.at_switching = at_switching;
  parameters.plant.machine = machine_of(task.at("machine"));
  parameters.plant.saturation = saturation_of(task);
  parameters.plant.points = points_of(task);
  parameters.plant.leakage = leakage_of(task);
  parameters.plant.iron_loss = iron_loss_of(task);
  parameters.plant.viscous_friction = task.value("friction", 0.0);
  parameters.link = link_of(task);
  parameters.thermal = thermal_of(task);
  parameters.driveline = driveline_of(task);
  parameters.io.u_dc = task.at("u_dc");
  parameters.io.period_ns = task.at("period_ns");
  return parameters;
}

template <class Stage>
Course course(const nlohmann::json& task, const SimulatedPowerStageParameters& parameters) {
  MechanicalLoad::Parameters load;
  load.load_torque = ProfileParameters{.value = task.at("tau_l")};
  if (task.contains("speed")) load.imposed_speed = ProfileParameters{.value = task.at("speed")};
  Stage stage{parameters, load};
  auto& io = stage.io();
  std::int64_t t_ns = 0;
  (void)io.read(t_ns);
  Course made;
  for (const char vector : task.at("sequence").get<std::string>()) {
    io.write({switch_states[std::size_t(vector - '0')], parameters.io.period_ns});
    t_ns += parameters.io.period_ns;
    const Measurement<double> measured = io.read(t_ns);
    if (!measured.plausible) break;
    made.tau_e.push_back(io.plant().tau_e());
    made.shaft.push_back(io.plant().acting(io.plant().inputs()).tau_l);
    made.u_dc.push_back(measured.u_dc);
  }
  // A read without time moves the temperatures to where the last period has led.
  (void)io.read(t_ns);
  const ThermalNodes<double> t = io.temperatures();
  made.temperatures = {t.winding, t.rotor, t.housing};
  return made;
}

}  // namespace
}  // namespace sextant

int main() {
  using sextant::AtSwitching;
  using sextant::IntegratorKind;
  const nlohmann::json task = nlohmann::json::parse(std::cin);
  nlohmann::json result;
  const auto play = [&](const char* name, IntegratorKind integrator,
                        AtSwitching at_switching = AtSwitching::by_tolerance) {
    const auto parameters = sextant::parameters_of(task, integrator, at_switching);
    const sextant::Course made =
        sextant::with_appended(parameters, [&]<class Appended>(std::type_identity<Appended>) {
          return parameters.thermal.acts()
                     ? sextant::course<sextant::MeteredPowerStageOf<Appended>>(task, parameters)
                     : sextant::course<sextant::PowerStageOf<Appended>>(task, parameters);
        });
    result[name] = made.tau_e;
    if (parameters.thermal.acts()) result["temperatures"][name] = made.temperatures;
    if (parameters.driveline.acts()) result["shaft"][name] = made.shaft;
    if (parameters.link.acts()) result["u_dc"][name] = made.u_dc;
  };
  play("cvode", IntegratorKind::cvode);
  play("cvode, stop", IntegratorKind::cvode, AtSwitching::stop);
  play("erk", IntegratorKind::erk);
  play("fixed", IntegratorKind::fixed);
  const auto of = sextant::parameters_of(task, IntegratorKind::exact, AtSwitching::by_tolerance).plant;
  if (!of.saturates() && !of.iron_loss.acts()) play("exact", IntegratorKind::exact);
  std::puts(result.dump().c_str());
}
