// The load behind a driveline: its keys reach each plant, and what contradicts itself is refused.
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Settings = std::vector<std::string>;

const Settings whole{"plant.driveline.inertia_kg_m2=0.2", "plant.driveline.stiffness_nm_rad=800",
                     "plant.driveline.damping_nm_s_rad=1.5", "plant.driveline.backlash_rad=0.02",
                     "plant.driveline.gear_ratio=4"};

TEST(DrivelineConfig, IsNoneByDefault) {
  EXPECT_EQ(load_scenario_config(shipped_scenario).drive.plant.driveline, DrivelineParameters<>{});
  EXPECT_EQ(load_ecu_config(shipped_ecu).drive.plant.driveline, DrivelineParameters<>{});
  EXPECT_EQ(load_plant_config(shipped_plant).plant.driveline, DrivelineParameters<>{});
}

TEST(DrivelineConfig, EachKeyReachesItsOwnValueOfEachPlant) {
  const DrivelineParameters<> expected{0.2, 800, 1.5, 0.02, 4};
  EXPECT_EQ(load_scenario_config(shipped_scenario, whole).drive.plant.driveline, expected);
  EXPECT_EQ(load_plant_config(shipped_plant, whole).plant.driveline, expected);
  EXPECT_EQ(load_ecu_config(shipped_ecu, whole).drive.plant.driveline, expected);
}

TEST(DrivelineConfig, EachIntegratorMovesIt) {
  for (const char* integrator : {"cvode", "erk", "fixed", "exact"})
    EXPECT_EQ(ecu_refusal(shipped_ecu, with(whole, "plant.integrator", integrator)), "accepted");
}

TEST(DrivelineConfig, WhatMakesNoDrivelineIsRefused) {
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, with(whole, "plant.driveline.inertia_kg_m2", "0")),
      HasSubstr("plant.driveline: stiffness, damping, backlash and gear ratio need a driveline with an "
                "inertia above zero"));
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, with(whole, "plant.driveline.stiffness_nm_rad", "0")),
      HasSubstr("plant.driveline: the stiffness must be above zero where the driveline has an inertia"));
}

TEST(DrivelineConfig, ADrivelineThatTakesTooManyStepsIsRefused) {
  Settings fast = with(whole, "plant.driveline.damping_nm_s_rad", "1e6");
  fast.push_back("plant.integrator=fixed");
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, fast),
      HasSubstr("stiffness or damping of [plant.driveline] are too large for its inertia or the "
                "motor's; integrator = \"cvode\" with cvode.method = \"bdf\" is for stiff drivelines"));
  fast.back() = "plant.integrator=cvode";
  EXPECT_EQ(ecu_refusal(shipped_ecu, fast), "accepted");
}

TEST(DrivelineConfig, TakesNoImposedSpeed) {
  const std::string sentence =
      "load.kind: an imposed speed turns the motor whatever its load does: plant.driveline.inertia_kg_m2 "
      "must "
      "be 0, or the load a torque";
  EXPECT_THAT(ecu_refusal(shipped_ecu, with(whole, "load.kind", "imposed_speed")), HasSubstr(sentence));
  EXPECT_THAT(scenario_refusal(with(whole, "load.kind", "imposed_speed")), HasSubstr(sentence));
  try {
    (void)load_plant_config(shipped_plant, with(whole, "load.kind", "imposed_speed"));
    ADD_FAILURE() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr(sentence));
  }
}

TEST(DrivelineConfig, IsNoneOfAnEventExactRun) {
  EXPECT_THAT(scenario_refusal({"mode=event_exact", "plant.driveline.inertia_kg_m2=0.2",
                                "plant.driveline.stiffness_nm_rad=800"}),
              HasSubstr("an event-exact run has its load on the motor's shaft, plant.driveline.inertia_kg_m2 "
                        "must be 0"));
}

TEST(DrivelineConfig, IsThatOfThePlantInAnotherProcess) {
  EXPECT_THAT(
      ecu_refusal(shipped_ecu_hil, whole),
      HasSubstr("the driveline is that of the plant outside this process: set plant.driveline there"));
}

TEST(DrivelineConfig, ThePowerStageRefusesADrivelineThatIsNotItsOwn) {
  SimulatedPowerStageParameters p{.integrator = IntegratorKind::fixed};
  EXPECT_THROW((PowerStageOf<Driveline<double>>{p, {}}), std::runtime_error);
  p.driveline = {0.2, 800};
  EXPECT_EQ(p.validate(), nullptr);
  EXPECT_NO_THROW((PowerStageOf<Driveline<double>>{p, {}}));
  EXPECT_THROW((SimulatedPowerStage{p, {}}), std::runtime_error);
  EXPECT_THROW((PowerStageOf<LinkAndDriveline>{p, {}}), std::runtime_error);
  p.driveline = {0.2, 0};
  EXPECT_THAT(p.validate(), HasSubstr("stiffness must be above zero"));
}

}  // namespace
}  // namespace sextant
