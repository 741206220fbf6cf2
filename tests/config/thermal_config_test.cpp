// The thermal network of the plant's machine: its keys reach each plant, and what contradicts itself is
// refused.
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/power_stage/live_power_stage.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Settings = std::vector<std::string>;

const Settings whole{"plant.thermal.winding_j_per_k=1500",
                     "plant.thermal.rotor_j_per_k=2500",
                     "plant.thermal.housing_j_per_k=9000",
                     "plant.thermal.winding_to_rotor_w_per_k=1",
                     "plant.thermal.winding_to_housing_w_per_k=15",
                     "plant.thermal.rotor_to_housing_w_per_k=4",
                     "plant.thermal.winding_to_ambient_w_per_k=0.5",
                     "plant.thermal.rotor_to_ambient_w_per_k=0.25",
                     "plant.thermal.housing_to_ambient_w_per_k=12",
                     "plant.thermal.ambient_c=40",
                     "plant.thermal.winding_c=90",
                     "plant.thermal.rotor_c=100",
                     "plant.thermal.housing_c=60",
                     "plant.thermal.reference_c=25",
                     "plant.thermal.winding_per_k=0.00385",
                     "plant.thermal.rotor_per_k=0.0039",
                     "plant.thermal.step_ms=5"};

/// The same with another value of one key.
Settings with(const std::string& key, const std::string& value) {
  Settings settings = whole;
  settings.push_back("plant." + key + "=" + value);
  return settings;
}

TEST(ThermalConfig, IsNoneByDefault) {
  EXPECT_FALSE(load_scenario_config(shipped_scenario).drive.plant.thermal.acts());
  EXPECT_FALSE(load_ecu_config(shipped_ecu).drive.plant.thermal.acts());
  EXPECT_FALSE(load_plant_config(shipped_plant).plant.thermal.acts());
}

TEST(ThermalConfig, EachKeyReachesItsOwnValueOfEachPlant) {
  const ThermalParameters<> expected{{1500, 2500, 9000}, 1,  15,      4,      {0.5, 0.25, 12}, 40,
                                     {90, 100, 60},      25, 0.00385, 0.0039, 5'000'000};
  EXPECT_EQ(load_scenario_config(shipped_scenario, whole).drive.plant.thermal, expected);
  EXPECT_EQ(load_plant_config(shipped_plant, whole).plant.thermal, expected);
  EXPECT_EQ(load_ecu_config(shipped_ecu, whole).drive.plant.thermal, expected);
}

TEST(ThermalConfig, EachIntegratorAndLinkTakesIt) {
  for (const char* integrator : {"cvode", "erk", "fixed", "exact"})
    EXPECT_EQ(ecu_refusal(shipped_ecu, with("integrator", integrator)), "accepted");
  Settings linked = with("link.capacitance_f", "1e-3");
  linked.emplace_back("plant.link.source_ohm=0.2");
  EXPECT_EQ(ecu_refusal(shipped_ecu, linked), "accepted");
}

TEST(ThermalConfig, WhatMakesNoNetworkIsRefused) {
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.thermal.ambient_c=30"}),
              HasSubstr("plant.thermal: conductances, temperatures and coefficients of the thermal network "
                        "need heat capacities above zero"));
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, with("thermal.rotor_j_per_k", "0")),
      HasSubstr("plant.thermal: winding, rotor and housing must each have a heat capacity above zero"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.thermal.winding_j_per_k=1", "plant.thermal.rotor_j_per_k=1",
                                        "plant.thermal.housing_j_per_k=1"}),
              HasSubstr("plant.thermal: winding, rotor and housing must each have conductances above zero on "
                        "a way to the ambient"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with("thermal.winding_j_per_k", "0.8")),
              HasSubstr("plant.thermal: the step of the thermal network must be at most a tenth"));
  Settings cold = with("thermal.winding_per_k", "0.02");
  cold.emplace_back("plant.thermal.winding_c=-30");
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, cold),
      HasSubstr("plant.thermal: the resistances must be above zero at the lowest of ambient and first"));
}

TEST(ThermalConfig, IsNoneOfAnEventExactRun) {
  Settings settings = whole;
  settings.emplace_back("mode=event_exact");
  try {
    (void)load_scenario_config(shipped_scenario, settings);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("an event-exact run has constant resistances, the heat capacities of "
                                        "plant.thermal must be 0"));
  }
}

TEST(ThermalConfig, IsThatOfThePlantInAnotherProcess) {
  EXPECT_THAT(ecu_refusal(shipped_ecu_hil, whole),
              HasSubstr("the machine is heated in the plant outside this process: set plant.thermal there"));
}

TEST(ThermalConfig, APowerStageWithoutAMeterRefusesIt) {
  SimulatedPowerStageParameters p{.integrator = IntegratorKind::fixed};
  p.thermal = load_ecu_config(shipped_ecu, whole).drive.plant.thermal;
  EXPECT_EQ(p.validate(), nullptr);
  EXPECT_THROW((SimulatedPowerStage{p, {}}), std::runtime_error);
}

/// A phase takes the current of a constant voltage through the resistance of a winding at 90 °C, on every
/// live plant: i = 2/3 u / (R_s (1 + 0.00385 · 65)).
TEST(ThermalConfig, ALivePlantHasTheResistancesOfItsTemperatures) {
  for (const bool linked : {false, true}) {
    SimulatedPowerStageParameters p{.integrator = IntegratorKind::fixed};
    p.thermal = load_ecu_config(shipped_ecu, whole).drive.plant.thermal;
    p.io.u_dc = 15;
    p.io.period_ns = 1'000'000;
    const double source = linked ? 0.05 : 0.0;
    if (linked) p.link = {1e-3, source};
    LivePowerStage stage{p, {}};
    Measurement<double> measured = stage.io().read(0);
    for (std::int64_t t_ns = 0; t_ns < 2'000'000'000; measured = stage.io().read(t_ns += p.io.period_ns))
      stage.io().write({switch_states[1], p.io.period_ns});
    ASSERT_TRUE(measured.plausible);
    EXPECT_NEAR(measured.i_abc.a, 10 / (0.435 * 1.25025 + 2.0 / 3.0 * source), 0.03);
  }
}

}  // namespace
}  // namespace sextant
