// The state in which the plant begins: its keys reach each plant, and what contradicts it is refused.
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

const Settings turning{"plant.initial_speed_rad_s=-60", "plant.initial_flux_wb=0.4"};

TEST(InitialStateConfig, ReachesEachPlantAndIsNoneByDefault) {
  const auto expect = [](const DrivePlantParameters<>& p, double speed, double flux) {
    EXPECT_EQ(p.initial.speed, speed);
    EXPECT_EQ(p.initial.rotor_flux, flux);
  };
  expect(load_scenario_config(shipped_scenario).drive.plant.plant, 0, 0);
  expect(load_scenario_config(shipped_scenario, turning).drive.plant.plant, -60, 0.4);
  expect(load_ecu_config(shipped_ecu, turning).drive.plant.plant, -60, 0.4);
  expect(load_plant_config(shipped_plant, turning).plant.plant, -60, 0.4);
}

TEST(InitialStateConfig, AnImposedSpeedIsThatOfTheShaftFromTheBeginning) {
  EXPECT_THAT(ecu_refusal(shipped_ecu, with(turning, "load.kind", "imposed_speed")),
              HasSubstr("load.kind: an imposed speed is that of the shaft from the beginning: "
                        "plant.initial_speed_rad_s must be 0, or the load a torque"));
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"load.kind=imposed_speed", "plant.initial_flux_wb=0.4"}), "accepted");
}

TEST(InitialStateConfig, ASpeedAboveTheTripIsRefused) {
  const Settings fast{"plant.initial_speed_rad_s=-400", "protection.over_speed_rad_s=300"};
  const std::string sentence =
      "plant.initial_speed_rad_s: the shaft begins with 400 rad/s, above protection.over_speed_rad_s, 300 "
      "rad/s: the drive would trip; lower the speed or raise the trip level";
  EXPECT_THAT(ecu_refusal(shipped_ecu, fast), HasSubstr(sentence));
  EXPECT_THAT(scenario_refusal(fast), HasSubstr(sentence));
  Settings expected = fast;
  expected.emplace_back("expect.fault=OVER_SPEED");
  EXPECT_EQ(scenario_refusal(expected), "accepted");
}

TEST(InitialStateConfig, AFluxThatTheLinkCannotMakeIsRefused) {
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, {"plant.initial_flux_wb=100", "plant.u_dc_v=300"}),
      HasSubstr("plant: initial_flux_wb is more than this [machine] can have behind a link of u_dc_v, 300 "
                "V: lower it"));
}

TEST(InitialStateConfig, IsThatOfThePlantOutsideTheEcu) {
  for (const std::string& setting : turning)
    EXPECT_THAT(ecu_refusal(shipped_ecu_hil, {setting}),
                HasSubstr("set plant.initial_speed_rad_s and initial_flux_wb there"));
}

TEST(InitialStateConfig, IsNoneOfAnEventExactRun) {
  for (const std::string& setting : turning)
    EXPECT_THAT(scenario_refusal({"mode=event_exact", setting}),
                HasSubstr("plant.initial_speed_rad_s and initial_flux_wb must be 0"));
}

}  // namespace
}  // namespace sextant
