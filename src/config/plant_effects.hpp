#pragma once

#include <array>
#include <string>

#include "sextant/config/sensor_config.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {

/// What of the simulated plant is more than machine, load, ideal inverter and stiff link, and why some runs
/// have none of it; null where they may.
struct PlantEffect {
  bool (*acts)(const SimulatedPowerStageParameters&);
  const char* elsewhere;    ///< with the plant outside the process
  const char* event_exact;  ///< in an event-exact run
};

inline constexpr std::array plant_effects{
    PlantEffect{
        [](const auto& p) { return p.io.measures_angle; },
        "the link to a plant outside this process carries no angle: plant.measures_angle must be false",
        nullptr},
    PlantEffect{[](const auto& p) { return p.io.measures_winding_temperature; },
                "the link to a plant outside this process carries no temperature: "
                "plant.measures_winding_temperature must be false",
                nullptr},
    PlantEffect{[](const auto& p) { return !is_ideal(p.io) || p.plant.drops.act(); },
                "sensors and inverter are those of the plant outside this process: set plant.sensors, "
                "plant.inverter and plant.faults there",
                "an event-exact run has no samples and an ideal inverter, plant.sensors must be ideal, "
                "plant.inverter.dead_time_us 0, minimum_pulse_us 0, threshold_v 0, slope_ohm 0 and "
                "plant.faults.kind \"none\""},
    PlantEffect{
        [](const auto& p) { return p.io.law == InverterLaw::averaged; }, nullptr,
        "an event-exact run is made of the inverter's edges, plant.inverter.law must be \"switched\""},
    PlantEffect{[](const auto& p) { return p.link.acts(); },
                "the DC link is that of the plant outside this process: set plant.link there",
                "an event-exact run has a stiff DC link, plant.link.capacitance_f must be 0"},
    PlantEffect{
        [](const auto& p) { return p.thermal.acts(); },
        "the machine is heated in the plant outside this process: set plant.thermal there",
        "an event-exact run has constant resistances, the heat capacities of plant.thermal must be 0"},
    PlantEffect{
        [](const auto& p) { return p.losses.acts(); },
        "the inverter loses its power in the plant outside this process: set plant.inverter.losses there",
        "an event-exact run has an inverter without losses, plant.inverter.losses must have no curve"},
    PlantEffect{
        [](const auto& p) { return p.driveline.acts(); },
        "the driveline is that of the plant outside this process: set plant.driveline there",
        "an event-exact run has its load on the motor's shaft, plant.driveline.inertia_kg_m2 must be 0"},
    PlantEffect{
        [](const auto& p) { return p.plant.initial.speed != 0 || p.plant.initial.rotor_flux != 0; },
        "the plant outside this process begins as its own file has it: set plant.initial_speed_rad_s and "
        "initial_flux_wb there",
        "an event-exact run begins at rest and with event_exact.initial_flux_wb, "
        "plant.initial_speed_rad_s and initial_flux_wb must be 0"}};

/// Of the first effect that acts and that such a run does not have, why; empty where there is none.
[[nodiscard]] inline std::string excluded_effect(const SimulatedPowerStageParameters& plant,
                                                 const char* PlantEffect::* why) {
  for (const PlantEffect& effect : plant_effects) {
    if (effect.*why != nullptr && effect.acts(plant)) return effect.*why;
  }
  return {};
}

}  // namespace sextant
