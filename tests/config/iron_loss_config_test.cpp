// Iron loss of the plant's machine: its keys reach each plant, and what contradicts itself is refused.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "config/plant_refusals.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Settings = std::vector<std::string>;

TEST(IronLossConfig, IsOffByDefault) {
  EXPECT_FALSE(load_scenario_config(shipped_scenario).drive.plant.plant.iron_loss.acts());
  EXPECT_FALSE(load_ecu_config(shipped_ecu).drive.plant.plant.iron_loss.acts());
  EXPECT_FALSE(load_plant_config(shipped_plant).plant.plant.iron_loss.acts());
}

TEST(IronLossConfig, GoesToThePlantAndNotToTheDrive) {
  const Settings settings{"plant.iron_loss.eddy_ohm=600", "plant.iron_loss.hysteresis_ohm=900",
                          "plant.iron_loss.at_rad_s=377"};
  const IronLossParameters<> expected{600, 900, 377};
  EXPECT_EQ(load_scenario_config(shipped_scenario, settings).drive.plant.plant.iron_loss, expected);
  EXPECT_EQ(load_plant_config(shipped_plant, settings).plant.plant.iron_loss, expected);
  const DriveConfig told = load_ecu_config(shipped_ecu, settings).drive;
  EXPECT_EQ(told.plant.plant.iron_loss, expected);
  const SimulatedPowerStage::Plant plant{told.plant.plant};
  EXPECT_TRUE(plant.machine().has_iron_loss());
}

/// The machine of the file: k_r L_m = 80.84 mH, 25.4 Ω at 314.159 rad/s.
TEST(IronLossConfig, AHysteresisThatHoldsTheFluxIsRefused) {
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.iron_loss.hysteresis_ohm=25.3"}),
              HasSubstr("plant: iron_loss.hysteresis_ohm must be above 25.4 ohm"));
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"plant.iron_loss.hysteresis_ohm=25.5"}), "accepted");
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.iron_loss.hysteresis_ohm=25.5", "plant.saturation.knee_wb=1",
                                        "plant.saturation.exponent=2", "plant.saturation.machine_flux_wb=1"}),
              HasSubstr("plant: iron_loss.hysteresis_ohm must be above 50.79 ohm"));
}

TEST(IronLossConfig, AWrongHysteresisIsOneSentence) {
  for (const std::string& refusal : refusals_of_each({"plant.iron_loss.hysteresis_ohm=25.3"})) {
    EXPECT_THAT(refusal, HasSubstr("iron_loss.hysteresis_ohm must be above"));
    EXPECT_THAT(refusal, Not(HasSubstr("\n")));
  }
}

TEST(IronLossConfig, TheExactIntegratorIsRefused) {
  for (const char* key : {"plant.iron_loss.eddy_ohm=600", "plant.iron_loss.hysteresis_ohm=900"}) {
    EXPECT_THAT(ecu_refusal(shipped_ecu, {key, "plant.integrator=exact"}),
                HasSubstr("plant: integrator = \"exact\" is for machines without iron loss: with "
                          "iron_loss.eddy_ohm or iron_loss.hysteresis_ohm above 0 it must be \"cvode\", "
                          "\"erk\" or \"fixed\""));
    for (const char* integrator : {"cvode", "erk", "fixed"}) {
      EXPECT_EQ(ecu_refusal(shipped_ecu, {key, std::string{"plant.integrator="} + integrator}), "accepted");
    }
  }
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"plant.iron_loss.at_rad_s=100", "plant.integrator=exact"}), "accepted");
  SimulatedPowerStage::Parameters stage{.integrator = IntegratorKind::exact};
  EXPECT_EQ(stage.validate(), nullptr);
  stage.plant.iron_loss.eddy_resistance = 600;
  EXPECT_THAT(stage.validate(), HasSubstr("machines without iron loss only"));
}

}  // namespace
}  // namespace sextant
