#include "sextant/config/ecu_config.hpp"

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sextant/config/sensor_config.hpp"

namespace sextant {
namespace {

/// Checks the durations that the wake period must not exceed.
std::string check_wake_period(const EcuConfig& c) {
  const std::int64_t wake_ns = std::int64_t{c.realtime.wake_every_periods} * c.drive.drive.period_ns;
  if (c.realtime.watchdog_ns < 2 * wake_ns) {
    return "watchdog_ms is too short: it must be at least twice wake_every_periods control periods";
  }
  if (const char* const problem = c.realtime.validate(wake_ns)) return problem;
  if (c.drive.drive.command.timeout_ns <= wake_ns) {
    return "wake_every_periods is too large: these control periods take longer than command.timeout_ms";
  }
  return {};
}

struct PowerStageName {
  std::string_view name;
  PowerStageKind kind;
};

constexpr std::array power_stage_names{PowerStageName{"simulated", PowerStageKind::simulated},
                                       PowerStageName{"shared_memory", PowerStageKind::shared_memory},
                                       PowerStageName{"udp", PowerStageKind::udp}};

std::string power_stage_name(const EcuConfig& c) {
  for (const PowerStageName& known : power_stage_names) {
    if (known.kind == c.power_stage) return std::string{known.name};
  }
  return c.own_name;
}

void choose_power_stage(EcuConfig& c, std::string_view name) {
  c.power_stage = PowerStageKind::own;
  for (const PowerStageName& known : power_stage_names) {
    if (known.name == name) c.power_stage = known.kind;
  }
  c.own_name = c.power_stage == PowerStageKind::own ? name : std::string_view{};
}

void describe_power_stage(Section root, EcuConfig& c) {
  std::vector<std::string> names;
  names.reserve(std::size(power_stage_names) + c.own_power_stages.size());
  for (const PowerStageName& known : power_stage_names) names.emplace_back(known.name);
  std::string meaning = "a plant in this process, in another one of this machine, or on another machine";
  for (const auto& own : c.own_power_stages) {
    names.emplace_back(own->name());
    meaning += "; " + names.back() + ": " + own->meaning();
  }
  root.add("power_stage", "", meaning.c_str(),
           ChoiceField{std::move(names), [&c] { return power_stage_name(c); },
                       [&c](std::string_view name) { choose_power_stage(c, name); }});
}

void describe_own_power_stages(const Section& root, EcuConfig& c) {
  for (auto& own : c.own_power_stages) {
    Section table = root.section(own->name());
    own->describe_table(table, c.drive.control);
    table.optional([&c, name = std::string{own->name()}] { return c.own_name == name; });
  }
}

/// What of [plant] would change the simulated plant, as a power stage that the program brings has none.
bool shapes_simulated_plant(const SimulatedPowerStage::Parameters& p) {
  return p.io.measures_angle || p.io.measures_winding_temperature || !is_ideal(p.io) || p.plant.drops.act() ||
         p.link.acts() || p.thermal.acts() || p.losses.acts() || p.driveline.acts() ||
         p.plant.initial.speed != 0 || p.plant.initial.rotor_flux != 0;
}

std::string check_own_power_stage(const EcuConfig& c) {
  if (shapes_simulated_plant(c.drive.plant)) {
    return "power_stage = \"" + c.own_name +
           "\" leaves the simulated plant out: leave its sensors, inverter, faults, link, thermal model, "
           "driveline and initial state out of [plant]";
  }
  if (c.waits_for_drive() || c.realtime.wake_every_periods == 1) return {};
  return "power_stage = \"" + c.own_name + "\" does not wait: realtime.wake_every_periods must be 1";
}

/// A power stage that does not wait for the drive receives one pattern a wake-up and applies it a period
/// later.
std::string check_power_stage(const EcuConfig& c) {
  if (c.power_stage == PowerStageKind::own) return check_own_power_stage(c);
  const bool elsewhere = c.power_stage != PowerStageKind::simulated;
  if (c.power_stage == PowerStageKind::udp && c.hil.pacing == Pacing::lockstep) {
    return "pacing = \"lockstep\" needs power_stage = \"shared_memory\": datagrams get lost";
  }
  if (elsewhere && c.drive.plant.io.measures_angle) {
    return "the link to a plant outside this process carries no angle: plant.measures_angle must be false";
  }
  if (elsewhere && c.drive.plant.io.measures_winding_temperature) {
    return "the link to a plant outside this process carries no temperature: "
           "plant.measures_winding_temperature must be false";
  }
  if (elsewhere && (!is_ideal(c.drive.plant.io) || c.drive.plant.plant.drops.act())) {
    return "sensors and inverter are those of the plant outside this process: set plant.sensors, "
           "plant.inverter and plant.faults there";
  }
  if (elsewhere && c.drive.plant.link.acts())
    return "the DC link is that of the plant outside this process: set plant.link there";
  if (elsewhere && c.drive.plant.thermal.acts())
    return "the machine is heated in the plant outside this process: set plant.thermal there";
  if (elsewhere && c.drive.plant.losses.acts())
    return "the inverter loses its power in the plant outside this process: set plant.inverter.losses there";
  if (elsewhere && c.drive.plant.driveline.acts())
    return "the driveline is that of the plant outside this process: set plant.driveline there";
  const InitialState<double>& initial = c.drive.plant.plant.initial;
  if (elsewhere && (initial.speed != 0 || initial.rotor_flux != 0)) {
    return "the plant outside this process begins as its own file has it: set plant.initial_speed_rad_s and "
           "initial_flux_wb there";
  }
  if (!elsewhere || c.hil.pacing == Pacing::lockstep) return {};
  if (c.realtime.wake_every_periods > 1) {
    return "a plant in real time outside this process does not wait: realtime.wake_every_periods must be 1, "
           "or hil.pacing \"lockstep\"";
  }
  if (c.drive.control.actuation_delay_periods != 1) {
    return "a plant outside this process applies a pattern one period after the decision: "
           "drive.actuation_delay_periods must be 1";
  }
  return {};
}

}  // namespace

const OwnPowerStage& EcuConfig::own_power_stage() const {
  for (const auto& own : own_power_stages) {
    if (own->name() == own_name) return *own;
  }
  throw std::logic_error("there is no power stage \"" + own_name + "\"");
}

bool EcuConfig::waits_for_drive() const {
  switch (power_stage) {
    case PowerStageKind::simulated:
      return true;
    case PowerStageKind::own:
      return own_power_stage().waits_for_drive();
    case PowerStageKind::shared_memory:
    case PowerStageKind::udp:
      break;
  }
  return hil.pacing == Pacing::lockstep;
}

void describe(Section root, EcuConfig& c) {
  root.integer("drive_id", c.drive_id, "", 0, 65'535, "key of a drive among those of a DDS domain");
  describe_power_stage(root, c);
  describe(root, c.drive);
  describe_own_power_stages(root, c);
  check_simulated_plant(root, c.drive, [&c] { return c.power_stage == PowerStageKind::simulated; });
  Section hil = root.section("hil");
  describe_parameters(hil, c.hil);
  hil.check([&c] { return check_power_stage(c); });
  Section realtime = root.section("realtime");
  describe_parameters(realtime, c.realtime);
  realtime.check([&c] { return check_wake_period(c); });
  describe_parameters(root.section("can"), c.can);
  Section dds = root.section("dds");
  describe(dds, c.dds);
}

}  // namespace sextant
