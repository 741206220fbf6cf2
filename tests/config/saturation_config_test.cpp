// Saturation of the plant's machine: its keys reach each plant, and what contradicts itself is refused.
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

TEST(SaturationConfig, IsOffByDefault) {
  EXPECT_FALSE(load_scenario_config(shipped_scenario).drive.plant.plant.saturation.acts());
  EXPECT_FALSE(load_ecu_config(shipped_ecu).drive.plant.plant.saturation.acts());
  EXPECT_FALSE(load_plant_config(shipped_plant).plant.plant.saturation.acts());
}

TEST(SaturationConfig, GoesToThePlantAndNotToTheDrive) {
  const Settings settings{"plant.saturation.knee_wb=1.2", "plant.saturation.exponent=9",
                          "plant.saturation.machine_flux_wb=1.1"};
  const SaturationParameters<> expected{1.2, 9, 1.1};
  EXPECT_EQ(load_scenario_config(shipped_scenario, settings).drive.plant.plant.saturation, expected);
  EXPECT_EQ(load_plant_config(shipped_plant, settings).plant.plant.saturation, expected);
  const DriveConfig told = load_ecu_config(shipped_ecu, settings).drive;
  EXPECT_EQ(told.plant.plant.saturation, expected);
  EXPECT_EQ(told.control.machine.l_m, load_ecu_config(shipped_ecu).drive.control.machine.l_m);
  const SimulatedPowerStage::Plant plant{told.plant.plant};
  EXPECT_FALSE(plant.machine().is_linear());
}

// The drive's own curve; its limits and its controller have the inductance of the flux reference.
TEST(SaturationConfig, TheDriveIsToldOfItsOwn) {
  EXPECT_FALSE(load_ecu_config(shipped_ecu).drive.control.saturation.acts());
  const std::string table = "control.machine_estimate.saturation.";
  const Settings settings{table + "knee_wb=1.1", table + "exponent=2", "control.flux_reference_wb=1.1"};
  const DriveConfig told = load_ecu_config(shipped_ecu, settings).drive;
  EXPECT_FALSE(told.plant.plant.saturation.acts());
  EXPECT_EQ(told.control.saturation, (SaturationParameters<>{1.1, 2, 1.1}));
  const double small = told.plant.plant.machine.l_m;
  EXPECT_NEAR(told.control.machine.l_m, 0.5 * small, 1e-9);
  EXPECT_EQ(told.drive.motor.capability.machine.l_m, told.control.machine.l_m);
  EXPECT_EQ(told.drive.torque_monitor.machine.l_m, told.control.machine.l_m);
  EXPECT_THAT(ecu_refusal(shipped_ecu, {table + "knee_wb=1", table + "machine_flux_wb=3"}),
              HasSubstr("control.machine_estimate.saturation: the flux at which"));
}

TEST(SaturationConfig, AFluxFarAboveTheKneeIsRefused) {
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.saturation.knee_wb=1", "plant.saturation.exponent=2",
                                        "plant.saturation.machine_flux_wb=3.1"}),
              HasSubstr("plant.saturation: the flux at which the machine's inductances hold is too far above "
                        "the knee of the saturation"));
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"plant.saturation.knee_wb=1", "plant.saturation.exponent=2",
                                      "plant.saturation.machine_flux_wb=2.9"}),
            "accepted");
}

TEST(SaturationConfig, AWrongKneeIsOneSentence) {
  const Settings settings{"plant.saturation.knee_wb=1", "plant.saturation.exponent=2",
                          "plant.saturation.machine_flux_wb=3.1"};
  for (const std::string& refusal : refusals_of_each(settings)) {
    EXPECT_THAT(refusal, HasSubstr("plant.saturation: the flux at which"));
    EXPECT_THAT(refusal, Not(HasSubstr("\n")));
  }
}

TEST(SaturationConfig, TheExactIntegratorIsRefused) {
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.saturation.knee_wb=1.2", "plant.integrator=exact"}),
              HasSubstr("plant: integrator = \"exact\" is for machines without saturation: with "
                        "saturation.knee_wb above 0 it must be \"cvode\", \"erk\" or \"fixed\""));
  for (const char* integrator : {"cvode", "erk", "fixed"}) {
    EXPECT_EQ(ecu_refusal(shipped_ecu,
                          {"plant.saturation.knee_wb=1.2", std::string{"plant.integrator="} + integrator}),
              "accepted");
  }
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"plant.saturation.knee_wb=0", "plant.integrator=exact"}), "accepted");
  SimulatedPowerStage::Parameters stage{.integrator = IntegratorKind::exact};
  EXPECT_EQ(stage.validate(), nullptr);
  stage.plant.saturation.knee = 1.2;
  EXPECT_THAT(stage.validate(), HasSubstr("machines without saturation only"));
}

TEST(SaturationConfig, PointsAndLeakageGoToThePlant) {
  const Settings settings{"plant.saturation.points=[[0.5, 5.5], [0.9, 10.5], [1.1, 16], [1.25, 28]]",
                          "plant.saturation.leakage.knee_wb=0.15", "plant.saturation.leakage.exponent=3"};
  const DrivePlantParameters<> plant = load_ecu_config(shipped_ecu, settings).drive.plant.plant;
  EXPECT_EQ(plant.points, (MagnetisingPoints<>{{{0.5, 5.5}, {0.9, 10.5}, {1.1, 16}, {1.25, 28}}}));
  EXPECT_EQ(plant.leakage, (LeakageSaturation<>{0.15, 3}));
  EXPECT_EQ(load_plant_config(shipped_plant, settings).plant.plant.points, plant.points);
  EXPECT_EQ(load_scenario_config(shipped_scenario, settings).drive.plant.plant.leakage, plant.leakage);
  EXPECT_TRUE(SimulatedPowerStage::Plant{plant}.machine().has_saturated_leakage());
  const ConfigFiles files;
  const std::string printed = print_config(load_ecu_config(shipped_ecu, settings));
  EXPECT_EQ(print_config(load_ecu_config(files.write("printed.toml", printed))), printed);
}

TEST(SaturationConfig, PointsThatMakeNoCurveAreRefused) {
  const std::string key = "plant.saturation.points=";
  const auto why = [&](const std::string& points, const Settings& more = {}) {
    Settings settings{key + points};
    settings.insert(settings.end(), more.begin(), more.end());
    return ecu_refusal(shipped_ecu, settings);
  };
  EXPECT_THAT(why("[[1, 10]]"), HasSubstr("plant.saturation: the points of the saturation must be none, or"));
  EXPECT_THAT(why("[[1, 10]]"), Not(HasSubstr("machines/"))) << "one sentence";
  EXPECT_THAT(why("[[1, 10], [0.9, 20]]"), HasSubstr("must rise from above zero in flux and current"));
  EXPECT_THAT(why("[[0, 0], [1, 20]]"), HasSubstr("plant.saturation.points: expected"));
  EXPECT_THAT(why("[[1, 10], [1.2, 11]]"), HasSubstr("must end where the current rises more than"));
  EXPECT_THAT(why("[[1, 0.5], [1.2, 11]]"),
              HasSubstr("plant.saturation.points: the points of the saturation make"));
  EXPECT_THAT(why("[[1, 10], [1.2, 20]]", {"plant.saturation.knee_wb=1"}), HasSubstr("not by both"));
  EXPECT_THAT(why("[[1, 10], [1.2, 20]]", {"plant.integrator=exact"}),
              HasSubstr("with saturation.points it must be"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.saturation.leakage.knee_wb=0.1", "plant.integrator=exact"}),
              HasSubstr("with saturation.leakage.knee_wb above 0 it must be"));
}

}  // namespace
}  // namespace sextant
