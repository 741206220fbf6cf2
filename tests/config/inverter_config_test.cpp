// What the drive knows of its inverter reaches every part that reads it.
#include <any>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(InverterConfig, IsIdealUnlessItIsGiven) {
  const DriveConfig c = load_ecu_config(shipped_ecu).drive;
  EXPECT_TRUE(c.control.inverter.is_ideal());
  EXPECT_EQ(c.plant.io.dead_time_ns, 0);
  EXPECT_FALSE(c.plant.plant.drops.act());
}

TEST(InverterConfig, ThePlantHasDropsOfItsOwn) {
  const DriveConfig c =
      load_ecu_config(shipped_ecu, {"plant.inverter.threshold_v=1.2", "plant.inverter.slope_ohm=0.02"}).drive;
  EXPECT_EQ(c.plant.plant.drops.threshold_voltage, 1.2);
  EXPECT_EQ(c.plant.plant.drops.slope_resistance, 0.02);
  EXPECT_TRUE(c.control.inverter.is_ideal());
  EXPECT_EQ(c.control.machine.r_s, c.plant.plant.machine.r_s);
}

TEST(InverterConfig, GoesToControllerProtectionsAndTorqueMonitor) {
  const DriveConfig c =
      load_ecu_config(shipped_ecu, {"drive.inverter.dead_time_us=1.5", "drive.inverter.threshold_v=1.2",
                                    "drive.inverter.slope_ohm=0.02"})
          .drive;
  const auto& foc = c.parameters<FieldOrientedController<>>();
  for (const InverterModel<>::Parameters& p :
       {c.direct_torque().inverter, foc.inverter, c.drive.protection.inverter,
        c.drive.torque_monitor.inverter}) {
    EXPECT_EQ(p.dead_time_ns, 1'500);
    EXPECT_EQ(p.threshold_voltage, 1.2);
    EXPECT_EQ(p.slope_resistance, 0.02);
    EXPECT_EQ(p.voltage_error, c.control.inverter.voltage_error);
  }
  EXPECT_EQ(c.plant.io.dead_time_ns, 0) << "the plant is told by its own key";
}

// A tenth of 4/π times the mean voltage that a dead time and a threshold take.
TEST(InverterConfig, TheVoltageErrorFollowsFromWhatIsToldUnlessItIsGiven) {
  const std::vector<std::string> told{"drive.period_us=25", "plant.u_dc_v=500",
                                      "drive.inverter.dead_time_us=1.5", "drive.inverter.threshold_v=1.2"};
  EXPECT_EQ(load_ecu_config(shipped_ecu).drive.control.inverter.voltage_error, 0.0);
  EXPECT_NEAR(load_ecu_config(shipped_ecu, told).drive.control.inverter.voltage_error,
              0.1 * 4 / 3.141592653589793 * (500 * 1.5 / 25 + 1.2), 1e-9);
  std::vector<std::string> given = told;
  given.push_back("drive.inverter.voltage_error_v=2.5");
  EXPECT_EQ(load_ecu_config(shipped_ecu, given).drive.control.inverter.voltage_error, 2.5);
}

TEST(InverterConfig, PlantAndDriveHaveAMinimumPulseOfTheirOwn) {
  const std::vector<std::string> plant{"plant.inverter.minimum_pulse_us=2",
                                       "plant.inverter.short_pulses=stretched"};
  const DriveConfig untold = load_ecu_config(shipped_ecu, plant).drive;
  EXPECT_EQ(untold.plant.io.minimum_pulse.duration_ns, 2'000);
  EXPECT_EQ(untold.plant.io.minimum_pulse.short_pulses, ShortPulses::stretched);
  EXPECT_TRUE(untold.control.inverter.is_ideal());
  const DriveConfig told = load_ecu_config(shipped_ecu, {"drive.inverter.minimum_pulse_us=1.5",
                                                         "drive.inverter.short_pulses=stretched"})
                               .drive;
  for (const InverterModel<>::Parameters& p :
       {told.direct_torque().inverter, told.drive.protection.inverter, told.drive.torque_monitor.inverter}) {
    EXPECT_FALSE(p.is_ideal());
    EXPECT_EQ(p.minimum_pulse.duration_ns, 1'500);
    EXPECT_EQ(p.minimum_pulse.short_pulses, ShortPulses::stretched);
  }
  EXPECT_EQ(told.plant.io.minimum_pulse.duration_ns, 0);
}

TEST(InverterConfig, AMinimumPulseBelowTheDeadTimeOrOfAQuarterOfAPeriodIsRefused) {
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, {"drive.inverter.minimum_pulse_us=6.25"}),
      HasSubstr("drive.inverter: the inverter's minimum pulse must be from zero to below a quarter of "
                "the control period"));
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"drive.inverter.minimum_pulse_us=6.2"}), "accepted");
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, {"drive.inverter.dead_time_us=1.5", "drive.inverter.minimum_pulse_us=1.4"}),
      HasSubstr("the inverter's minimum pulse must be zero or at least its dead time"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.inverter.minimum_pulse_us=12.5"}),
              HasSubstr("the minimum pulse must be from zero to below half of the control period"));
}

TEST(InverterConfig, AWrongValueIsToldOnce) {
  for (const char* setting : {"drive.inverter.dead_time_us=12.5", "drive.inverter.minimum_pulse_us=6.25"}) {
    SCOPED_TRACE(setting);
    const std::string told = ecu_refusal(shipped_ecu, {setting});
    EXPECT_THAT(told, HasSubstr("drive.inverter: "));
    EXPECT_THAT(told, Not(HasSubstr("\n"))) << "control and protection take the same values";
  }
}

TEST(InverterConfig, ADeadTimeOfHalfAPeriodIsRefused) {
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"drive.inverter.dead_time_us=12.5"}),
              HasSubstr("the inverter's dead time must be from zero to below half of the control period"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.inverter.dead_time_us=12.5"}),
              HasSubstr("the dead time must be from zero to below half of the control period"));
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"drive.inverter.dead_time_us=12.4"}), "accepted");
}

}  // namespace
}  // namespace sextant
