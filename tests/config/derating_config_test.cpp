// Keys by which temperature and link voltage act on the drive: they reach it, and what contradicts itself is
// refused.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
std::string refusal(const std::vector<std::string>& settings) {
  return ecu_refusal(shipped_ecu, settings);
}

TEST(DeratingConfig, IsNoneByDefault) {
  const DriveConfig drive = load_ecu_config(shipped_ecu).drive;
  EXPECT_FALSE(drive.control.winding.varies());
  EXPECT_FALSE(drive.drive.low_voltage.acts());
  EXPECT_FALSE(drive.drive.high_voltage.acts());
  EXPECT_FALSE(drive.plant.io.measures_winding_temperature);
}

TEST(DeratingConfig, EachKeyReachesTheDrive) {
  const DriveConfig drive =
      load_ecu_config(shipped_ecu, {"control.r_s_per_k=0.00385", "control.r_s_reference_c=25",
                                    "protection.winding.nominal_current_a=12", "capability.low_voltage_v=480",
                                    "capability.low_voltage_zero_v=410", "capability.high_voltage_v=600",
                                    "capability.high_voltage_zero_v=650"})
          .drive;
  EXPECT_EQ(drive.control.winding.per_kelvin, 0.00385);
  EXPECT_EQ(drive.control.winding.reference, 25);
  EXPECT_EQ(drive.drive.low_voltage.full, 480);
  EXPECT_EQ(drive.drive.low_voltage.zero, 410);
  EXPECT_EQ(drive.drive.high_voltage.full, 600);
  EXPECT_EQ(drive.drive.high_voltage.zero, 650);
  for (const auto& method : drive.methods) {
    EXPECT_NE(method->make(), nullptr) << method->name();
  }
  EXPECT_EQ(drive.direct_torque().winding.per_kelvin, 0.00385);
}

TEST(DeratingConfig, ATemperatureThatIsNotKnownIsRefused) {
  EXPECT_THAT(refusal({"control.r_s_per_k=0.00393"}), HasSubstr("control.r_s_per_k: R_s cannot follow"));
  EXPECT_EQ(refusal({"control.r_s_per_k=0.00393", "protection.winding.nominal_current_a=12"}), "accepted");
  EXPECT_THAT(refusal({"plant.measures_winding_temperature=true"}),
              HasSubstr("plant.measures_winding_temperature: the temperature of the winding is not known"));
}

TEST(DeratingConfig, BandsBeyondTheTripLevelsAreRefused) {
  EXPECT_THAT(refusal({"capability.low_voltage_v=480", "capability.low_voltage_zero_v=100"}),
              HasSubstr("capability: low_voltage_zero_v, 100 V, must be from protection.dc_under_voltage_v"));
  EXPECT_THAT(refusal({"capability.low_voltage_zero_v=400"}), HasSubstr("which is not set"));
  EXPECT_THAT(refusal({"capability.high_voltage_v=600", "capability.high_voltage_zero_v=590"}),
              HasSubstr("high_voltage_zero_v, 590 V, must be from above high_voltage_v, 600 V"));
  EXPECT_THAT(refusal({"capability.high_voltage_zero_v=600"}), HasSubstr("which is not set"));
}

TEST(DeratingConfig, TheDriveIsReadyFromTheBandOrTheTripLevelOnUnlessItIsSaid) {
  const auto ready = [](const std::vector<std::string>& settings) {
    return load_ecu_config(shipped_ecu, settings).drive.drive.ready_voltage;
  };
  EXPECT_EQ(ready({}), 265);
  EXPECT_EQ(ready({"protection.dc_under_voltage_v=300"}), 300);
  EXPECT_EQ(ready({"capability.low_voltage_v=480", "capability.low_voltage_zero_v=410"}), 410);
  EXPECT_EQ(ready({"capability.ready_voltage_v=500"}), 500);
  EXPECT_THAT(
      refusal({"capability.ready_voltage_v=200"}),
      HasSubstr("capability: ready_voltage_v, 200 V, must be from protection.dc_under_voltage_v, 265 V, "
                "to plant.u_dc_v, 530 V"));
  EXPECT_THAT(refusal({"capability.ready_voltage_v=531"}), HasSubstr("to plant.u_dc_v, 530 V"));
}

TEST(DeratingConfig, ALinkToAnotherProcessCarriesNoTemperature) {
  EXPECT_THAT(refusal({"power_stage=shared_memory", "plant.measures_winding_temperature=true"}),
              HasSubstr("plant.measures_winding_temperature must be false"));
}

}  // namespace
}  // namespace sextant
