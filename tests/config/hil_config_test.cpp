#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/hil/hil_parameters.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Settings = std::vector<std::string>;

std::string drive_refusal(const Settings& settings, const std::string& file = shipped_ecu_hil) {
  try {
    (void)load_ecu_config(file, settings);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

std::string plant_refusal(const Settings& settings) {
  try {
    (void)load_plant_config(shipped_plant, settings);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(HilConfig, TheShippedFilesFitEachOther) {
  const EcuConfig drive = load_ecu_config(shipped_ecu_hil);
  const PlantConfig plant = load_plant_config(shipped_plant);
  EXPECT_EQ(drive.power_stage_kind(), PowerStageKind::shared_memory);
  EXPECT_EQ(drive.drive.drive.period_ns, plant.period_ns);
  EXPECT_EQ(drive.hil.link, plant.hil.link);
  EXPECT_EQ(drive.hil.pacing, plant.hil.pacing);
  EXPECT_EQ(drive.drive.direct_torque().actuation_delay_periods, 1);
  EXPECT_LE(plant.hil.pattern_timeout_ns, 10'000'000) << "a dead drive's gates are off within 10 ms";
  EXPECT_EQ(drive.drive.direct_torque().machine.r_s, plant.plant.plant.machine.r_s);
}

TEST(HilConfig, APlantInRealTimeDoesNotWaitForSeveralPeriodsAWakeUp) {
  EXPECT_THAT(drive_refusal({"realtime.wake_every_periods=2"}),
              HasSubstr("realtime.wake_every_periods must be 1"));
  EXPECT_THAT(drive_refusal({"realtime.wake_every_periods=2", "power_stage=udp"}),
              HasSubstr("realtime.wake_every_periods must be 1"));
  EXPECT_EQ(drive_refusal({"realtime.wake_every_periods=40", "hil.pacing=lockstep"}), "accepted");
  EXPECT_THAT(drive_refusal({"power_stage=shared_memory"}, shipped_ecu),
              HasSubstr("realtime.wake_every_periods must be 1"));
  EXPECT_THAT(plant_refusal({"realtime.wake_every_periods=2"}),
              HasSubstr("realtime.wake_every_periods must be 1"));
}

TEST(HilConfig, APlantThatWaitsByTheHybridWayHasToSleep) {
  EXPECT_THAT(plant_refusal({"realtime.wait=hybrid", "realtime.spin_margin_us=100"}),
              HasSubstr("spin_margin_us is too long"));
  EXPECT_EQ(plant_refusal({"realtime.wait=hybrid", "realtime.spin_margin_us=99"}), "accepted");
  EXPECT_EQ(plant_refusal({"realtime.wait=hybrid", "realtime.spin_margin_us=100", "hil.pacing=lockstep"}),
            "accepted");
}

TEST(HilConfig, ALinkInRealTimeIsADelayOfOnePeriod) {
  EXPECT_THAT(drive_refusal({"drive.actuation_delay_periods=0"}),
              HasSubstr("drive.actuation_delay_periods must be 1"));
  EXPECT_THAT(plant_refusal({"drive.actuation_delay_periods=0"}),
              HasSubstr("drive.actuation_delay_periods must be 1"));
  EXPECT_EQ(plant_refusal({"drive.actuation_delay_periods=0", "hil.pacing=lockstep"}), "accepted");
}

TEST(HilConfig, ALinkCarriesNoAngle) {
  EXPECT_THAT(drive_refusal({"plant.measures_angle=true"}), HasSubstr("plant.measures_angle must be false"));
  EXPECT_EQ(drive_refusal({"plant.measures_angle=true", "power_stage=simulated"}), "accepted");
}

TEST(HilConfig, LockstepNeedsALinkThatLosesNothing) {
  EXPECT_THAT(drive_refusal({"power_stage=udp", "hil.pacing=lockstep"}), HasSubstr("datagrams get lost"));
  EXPECT_THAT(plant_refusal({"transport=udp", "hil.pacing=lockstep"}), HasSubstr("datagrams get lost"));
}

TEST(HilConfig, ALinkHasANameThatAFileCanHave) {
  for (const std::string name : {"a/b", ".hidden", "/x"}) {
    EXPECT_THAT(plant_refusal({"hil.link=\"" + name + "\""}), HasSubstr("link must be a name")) << name;
  }
}

}  // namespace
}  // namespace sextant
