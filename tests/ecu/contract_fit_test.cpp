#include "ecu/unit/contract_fit.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/config/load_config.hpp"
#include "support/source_directory.hpp"

namespace sextant::ecu {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string beyond(const std::vector<std::string>& overrides) {
  return beyond_contract(load_ecu_config(SEXTANT_SOURCE_DIR "/configs/ecu.toml", overrides).drive);
}

TEST(ContractFit, TheShippedDrivesFit) {
  for (const char* name : {"ecu.toml", "ecu_foc.toml", "ecu_hil.toml", "ecu_hard.toml"})
    EXPECT_EQ(beyond_contract(load_ecu_config(SEXTANT_SOURCE_DIR "/configs/" + std::string{name}).drive), "")
        << name;
}

TEST(ContractFit, EachValueBeyondItsSignalIsNamedWithTheRange) {
  const struct {
    std::string fits;
    std::string is_beyond;
    const char* said;
  } cases[] = {
      {"command.torque_limit_nm=250", "command.torque_limit_nm=250.1",
       "VCU_TorqueCommand.TorqueRequest carries -250 to 250 N·m, and command.torque_limit_nm is 250.1 N·m"},
      {"capability.torque_nm=250", "capability.torque_nm=251",
       "MCU_Capability.TorqueMotoring carries 0 to 250 N·m, and capability.torque_nm is 251 N·m"},
      {"protection.dc_over_voltage_v=1300", "protection.dc_over_voltage_v=1301",
       "MCU_Electrical.DcVoltage carries 0 to 1300 V, and protection.dc_over_voltage_v is 1301 V"},
      {"protection.over_current_a=1838", "protection.over_current_a=1840",
       "MCU_Electrical.PhaseCurrentRms carries 0 to 1300 A, and protection.over_current_a as RMS is 1301 A"},
      {"protection.over_speed_rad_s=1675", "protection.over_speed_rad_s=1676",
       "MCU_Motion.Speed carries -16000 to 16000 rpm, and protection.over_speed_rad_s is 1.6e+04 rpm"},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.is_beyond);
    EXPECT_EQ(beyond({one.fits}), "");
    const std::string said = beyond({one.is_beyond});
    EXPECT_THAT(said, testing::StartsWith(one.said));
    EXPECT_THAT(said, Not(HasSubstr("; ")));
  }
  const std::string both = beyond({"command.torque_limit_nm=300", "protection.dc_over_voltage_v=1301"});
  EXPECT_THAT(both, HasSubstr("is 300 N·m; MCU_Electrical.DcVoltage"));
}

}  // namespace
}  // namespace sextant::ecu
