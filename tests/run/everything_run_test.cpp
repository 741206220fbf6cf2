// Every effect of the plant at once under CVODE: the energies close. The file of the scenario is compared
// with the list of all keys, so that an effect that is added cannot be left out.

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/run/mil_runner.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

const std::string file = SEXTANT_SOURCE_DIR "/configs/scenarios/plant/everything.toml";

/// Tables and keys that are no effect of the plant, or that another key of the file stands for.
constexpr std::array not_effects{
    // How it is integrated.
    "plant.integrator", "plant.cvode.", "plant.fixed.", "plant.exact.", "plant.erk.",
    // In the place of the law of the main flux.
    "plant.saturation.points",
    // Not beside the losses, which are those of edges.
    "plant.inverter.law",
    // The shaft has one sensor: the resolver.
    "plant.sensors.encoder.", "plant.sensors.sin_cos.",
    // Something that is broken.
    "plant.faults.",
    // At what the curves of the losses hold.
    "plant.inverter.losses.cold_c", "plant.inverter.losses.hot_c", "plant.inverter.losses.energy_voltage_v",
    "plant.inverter.losses.switch_exponent", "plant.inverter.losses.diode_exponent",
    "plant.inverter.losses.ambient_c", "plant.inverter.losses.case_c"};

bool is_effect(std::string_view path) {
  if (!path.starts_with("plant.")) return false;
  return std::ranges::none_of(not_effects, [path](std::string_view of_table) {
    return of_table.ends_with('.') ? path.starts_with(of_table) : path == of_table;
  });
}

bool differs(const Field& a, const Field& b) {
  return a.member.get() != b.member.get();
}

Schema schema_of(ScenarioConfig& config) {
  Schema schema;
  describe(Section{schema}, config);
  return schema;
}

/// Keys of effects that are as a file has them that does not name them.
std::vector<std::string> effects_left_out(ScenarioConfig config) {
  ScenarioConfig defaults;
  const Schema here = schema_of(config);
  const Schema untouched = schema_of(defaults);
  std::vector<std::string> left_out;
  for (std::size_t k = 0; k < here.fields.size(); ++k) {
    const Field& field = here.fields[k];
    if (is_effect(field.path) && !differs(field, untouched.fields[k])) left_out.push_back(field.path);
  }
  return left_out;
}

TEST(EverythingRun, TheScenarioHasEveryEffectOfThePlant) {
  EXPECT_EQ(effects_left_out(load_scenario_config(file)), std::vector<std::string>{});
  EXPECT_EQ(
      effects_left_out(load_scenario_config(file, {"plant.link.source_h=0", "plant.sensors.current.bits=0"})),
      (std::vector<std::string>{"plant.link.source_h", "plant.sensors.current.bits"}));
}

TEST(EverythingRun, EveryExceptionIsOfAKey) {
  ScenarioConfig config;
  const Schema schema = schema_of(config);
  for (const std::string_view exception : not_effects) {
    EXPECT_TRUE(std::ranges::any_of(schema.fields, [exception](const Field& f) {
      return f.path.starts_with(exception);
    })) << exception;
  }
}

// scripts/nightly runs the ten seconds of the file.
TEST(EverythingRun, EnergyCloses) {
  ScenarioConfig config = load_scenario_config(
      file, {"duration_s=0.8", "profile.torque_nm.points=[[0, 0], [0.2, 60], [0.5, -60]]",
             "load.torque_nm.points=[[0, 0], [0.3, 8]]"});
  ASSERT_EQ(config.drive.plant.integrator, IntegratorKind::cvode);
  MeteredPowerStageOf<LinkAndDriveline> stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  const MilResult result =
      MilRunner{drive, stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
  EXPECT_FALSE(result.faults.any()) << to_string(result.first_fault);
  const MetricList& m = result.metrics;
  EXPECT_LT(m[Metric::energy_unaccounted], 1e-5);
  for (const Metric flown :
       {Metric::energy_iron, Metric::energy_inverter, Metric::energy_source_loss, Metric::energy_chopper,
        Metric::energy_friction, Metric::energy_damping, Metric::energy_load, Metric::short_pulses})
    EXPECT_GT(m[flown], 1.0) << int(flown);
  EXPECT_GT(m[Metric::winding_temperature], 31.0);
  EXPECT_LT(m[Metric::shaft_torque_min], -10.0);
  EXPECT_GT(m[Metric::shaft_torque_max], 10.0);
}

}  // namespace
}  // namespace sextant
