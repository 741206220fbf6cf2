#include "sextant/config/ecu_config.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "drive_sections.hpp"
#include "own_names.hpp"
#include "plant_effects.hpp"

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

constexpr std::array power_stages{Choice{"simulated", PowerStageKind::simulated},
                                  Choice{"shared_memory", PowerStageKind::shared_memory},
                                  Choice{"udp", PowerStageKind::udp}};

void describe_own_power_stages(const Section& root, EcuConfig& c) {
  for (auto& own : c.own_power_stages) {
    Section table = root.section(own->name());
    own->describe_table(table, c.drive.control);
    table.optional([&c, name = std::string{own->name()}] { return c.power_stage == name; });
  }
}

std::string check_own_power_stage(const EcuConfig& c) {
  if (!excluded_effect(c.drive.plant, &PlantEffect::elsewhere).empty()) {
    return "power_stage = \"" + c.power_stage +
           "\" leaves the simulated plant out: leave its sensors, inverter, faults, link, thermal model, "
           "driveline and initial state out of [plant]";
  }
  if (c.waits_for_drive() || c.realtime.wake_every_periods == 1) return {};
  return "power_stage = \"" + c.power_stage + "\" does not wait: realtime.wake_every_periods must be 1";
}

/// A power stage that does not wait for the drive receives one pattern a wake-up and applies it a period
/// later.
std::string check_power_stage(const EcuConfig& c) {
  if (c.power_stage_kind() == PowerStageKind::own) return check_own_power_stage(c);
  const bool elsewhere = c.power_stage_kind() != PowerStageKind::simulated;
  if (c.power_stage_kind() == PowerStageKind::udp && c.hil.pacing == Pacing::lockstep) {
    return "pacing = \"lockstep\" needs power_stage = \"shared_memory\": datagrams get lost";
  }
  if (!elsewhere) return {};
  if (std::string problem = excluded_effect(c.drive.plant, &PlantEffect::elsewhere); !problem.empty())
    return problem;
  if (c.hil.pacing == Pacing::lockstep) return {};
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

OwnPowerStages checked(const OwnPowerStages& own) {
  if (own.empty()) return own;
  EcuConfig config;
  Schema schema;
  describe(Section{schema}, config);
  std::vector<std::string> taken = names_in(schema, "");
  taken.insert(taken.end(), {"base", "on_fault"});
  for (const auto& known : power_stages) taken.emplace_back(known.name);
  for (const auto& power_stage : own) {
    take_name(taken, power_stage->name(), "power stage",
              "no other power stage and no key or table of the file");
  }
  return own;
}

PowerStageKind EcuConfig::power_stage_kind() const noexcept {
  for (const auto& known : power_stages) {
    if (known.name == power_stage) return known.value;
  }
  return PowerStageKind::own;
}

bool EcuConfig::waits_for_drive() const {
  switch (power_stage_kind()) {
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
  Names names;
  for (const auto& known : power_stages) names.emplace_back(known.name);
  describe_choice(root, "power_stage", c.power_stage, std::move(names),
                  "a plant in this process, in another one of this machine, or on another machine",
                  c.own_power_stages);
  describe(root, c.drive);
  describe_own_power_stages(root, c);
  check_simulated_plant(root, c.drive, [&c] { return c.power_stage_kind() == PowerStageKind::simulated; });
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
