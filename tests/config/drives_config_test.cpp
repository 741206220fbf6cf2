#include "sextant/config/drives_config.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Settings = std::vector<std::string>;

/// A drive's table that changes the shipped configuration.
std::string drive(const std::string& keys) {
  return "[[drive]]\nbase = \"" + shipped_ecu + "\"\n" + keys;
}

const std::string two = drive("drive_id = 1\n") + drive("drive_id = 5\ncan.identifier_offset = 32\n");

std::string refusal(const std::string& text, const Settings& settings = {}) {
  const ConfigFiles files;
  try {
    (void)load_drives_config(files.write("drives.toml", text), settings);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

DrivesConfig loaded(const std::string& text, const Settings& settings = {}) {
  const ConfigFiles files;
  return load_drives_config(files.write("drives.toml", text), settings);
}

TEST(DrivesConfig, AFileWithoutDriveTablesIsOneDrive) {
  const DrivesConfig config = load_drives_config(shipped_ecu);
  ASSERT_EQ(config.drives.size(), 1U);
  EXPECT_EQ(print_config(config.drives.front()), print_config(load_ecu_config(shipped_ecu)));
}

TEST(DrivesConfig, EachTableIsAConfigurationOfItsOwn) {
  const DrivesConfig config = loaded(two + "control.controller = \"foc\"\n");
  ASSERT_EQ(config.drives.size(), 2U);
  EXPECT_EQ(config.on_fault, OnFault::others_go_on);
  EXPECT_EQ(print_config(config.drives[0]), print_config(load_ecu_config(shipped_ecu, {"drive_id=1"})));
  EXPECT_EQ(print_config(config.drives[1]),
            print_config(load_ecu_config(
                shipped_ecu, {"drive_id=5", "can.identifier_offset=32", "control.controller=foc"})));
}

TEST(DrivesConfig, AnOverrideCountsForEveryDriveOrForTheProcess) {
  const DrivesConfig config = loaded(two, {"drive.period_us=50", "on_fault=all_shut_down"});
  EXPECT_EQ(config.on_fault, OnFault::all_shut_down);
  for (const EcuConfig& drive : config.drives) EXPECT_EQ(drive.drive.drive.period_ns, 50'000);
  EXPECT_EQ(loaded(two, {"on_fault = \"all_shut_down\""}).on_fault, OnFault::all_shut_down);
  EXPECT_EQ(loaded("on_fault = \"all_shut_down\"\n" + two, {"on_fault=others_go_on"}).on_fault,
            OnFault::others_go_on);
}

TEST(DrivesConfig, AnOverrideCountsForOneDriveByItsId) {
  const auto periods = [](const std::string& text, const Settings& settings) {
    std::vector<int> found;
    for (const EcuConfig& drive : loaded(text, settings).drives) found.push_back(drive.drive.drive.period_ns);
    return found;
  };
  EXPECT_THAT(periods(two, {"drive[5].drive.period_us=50"}), ElementsAre(25'000, 50'000));
  EXPECT_THAT(periods(two, {"drive[1].drive.period_us=50", "drive.period_us=40"}),
              ElementsAre(40'000, 40'000))
      << "the last one counts";
  EXPECT_THAT(periods(two, {"drive.period_us=40", "drive[1].drive.period_us=50"}),
              ElementsAre(50'000, 40'000));
  EXPECT_EQ(loaded(two, {"drive[5].on_fault=all_shut_down"}).on_fault, OnFault::all_shut_down)
      << "a key of the process is that of each drive";
  EXPECT_THAT(refusal(two, {"drive[2].drive.period_us=50"}),
              HasSubstr("--set: drive[2].drive.period_us=50: no drive has this drive_id; there is 1, 5"));
  EXPECT_THAT(refusal(two, {"drive[5].drive.period=50"}), HasSubstr("drive.period"));
}

TEST(DrivesConfig, AnOverrideForADriveThatIsNotThereIsRefusedWhateverItsKey) {
  for (const char* key : {"on_fault=all_shut_down", "drive_id=3", "drive.period_us=50"}) {
    const std::string setting = std::string{"drive[9]."} + key;
    EXPECT_THAT(refusal(two, {setting}),
                HasSubstr("--set: " + setting + ": no drive has this drive_id; there is 1, 5"));
  }
}

TEST(DrivesConfig, OverridesNameADriveByTheIdThatItHasInItsFile) {
  const auto ids = [](const DrivesConfig& config) {
    std::vector<int> found;
    for (const EcuConfig& drive : config.drives) found.push_back(drive.drive_id);
    return found;
  };
  EXPECT_THAT(ids(loaded(two, {"drive[5].drive_id=3"})), ElementsAre(1, 3));
  EXPECT_EQ(
      loaded(two, {"drive[5].drive_id=3", "drive[5].drive.period_us=50"}).drives[1].drive.drive.period_ns,
      50'000);
  EXPECT_THAT(refusal(two, {"drive[5].drive_id=3", "drive[3].drive.period_us=50"}),
              HasSubstr("drive[3].drive.period_us=50: no drive has this drive_id; there is 1, 5"));
  EXPECT_THAT(ids(load_drives_config(shipped_ecu, {"drive[1].drive_id=3"})), ElementsAre(3));
}

TEST(DrivesConfig, AFileOfOneDriveTakesItsIdToo) {
  EXPECT_EQ(
      load_drives_config(shipped_ecu, {"drive[1].drive.period_us=50"}).drives.front().drive.drive.period_ns,
      50'000);
  EXPECT_EQ(load_drives_config(shipped_ecu, {"drive_id=3", "drive[3].drive.period_us=50"})
                .drives.front()
                .drive.drive.period_ns,
            50'000);
  EXPECT_THROW((void)load_drives_config(shipped_ecu, {"drive[2].drive.period_us=50"}), ConfigError);
}

TEST(DrivesConfig, TheShippedFourLoad) {
  const DrivesConfig config = load_drives_config(SEXTANT_SOURCE_DIR "/configs/ecu_four.toml");
  EXPECT_EQ(config.drives.size(), 4U);
}

TEST(DrivesConfig, AFileOfOneOfSeveralHasItsId) {
  const DrivesConfig config = loaded(two);
  EXPECT_EQ(config.file_of("out/run.h5", 1), "out/run_5.h5");
  EXPECT_EQ(config.file_of("/tmp/set", 0), "/tmp/set_1");
  EXPECT_EQ(config.file_of("", 0), "");
  EXPECT_EQ(load_drives_config(shipped_ecu).file_of("out/run.h5", 0), "out/run.h5");
}

TEST(DrivesConfig, WhatExcludesEachOtherIsRefusedByKeyAndTable) {
  const std::string same = "drives.toml:4: drive: can.identifier_offset is the same in the tables 1 and 2";
  EXPECT_THAT(refusal(drive("drive_id = 1\n") + drive("drive_id = 2\n")), HasSubstr(same));
  EXPECT_THAT(refusal(two, {"drive_id=3"}), HasSubstr("drive_id is the same in the tables 1 and 2"));
  EXPECT_THAT(refusal(two + drive("drive_id = 1\ncan.identifier_offset = 64\n")),
              HasSubstr("drives.toml:8: drive: drive_id is the same in the tables 1 and 3"));
  EXPECT_THAT(refusal(two, {"realtime.cpu=1"}), HasSubstr("realtime.cpu is the same in the tables 1 and 2"));
  const Settings shared{"power_stage=shared_memory", "realtime.wake_every_periods=1",
                        "drive.actuation_delay_periods=1"};
  EXPECT_THAT(refusal(two, shared), HasSubstr("hil.link is the same in the tables 1 and 2"));
  const Settings udp{"power_stage=udp", "realtime.wake_every_periods=1", "drive.actuation_delay_periods=1"};
  EXPECT_THAT(refusal(two, udp), HasSubstr("hil.udp_listen is the same in the tables 1 and 2"));
  EXPECT_THAT(refusal(two + "can.bus = \"socketcan:can7\"\n"), HasSubstr("can.bus differs"));
  EXPECT_THAT(refusal(two + "dds.domain = 3\n"), HasSubstr("dds.domain differs"));
  std::string nine;
  for (int k = 0; k < 9; ++k) {
    nine += drive("drive_id = " + std::to_string(k) + "\ncan.identifier_offset = " + std::to_string(32 * k) +
                  "\n");
  }
  EXPECT_THAT(refusal(nine), HasSubstr("drives.toml:33: drive: a process has at most 8 drives"));
}

TEST(DrivesConfig, WhatIsPrintedLoadsAsTheSame) {
  const DrivesConfig config =
      loaded("on_fault = \"all_shut_down\"\n" + two + "control.controller = \"foc\"\n");
  const std::string printed = print_config(config);
  EXPECT_EQ(print_config(loaded(printed)), printed);
}

TEST(DrivesConfig, AWrongKeyIsRefusedAtItsLine) {
  EXPECT_THAT(refusal(two + "drive.period_is = 3\n"),
              HasSubstr("drives.toml:8: drive.period_is: unknown key"));
  EXPECT_THAT(refusal("drive_id = 1\n" + two), HasSubstr("drives.toml:1: drive_id: unknown key"));
  EXPECT_THAT(refusal("on_fault = \"none\"\n" + two), HasSubstr("drives.toml:1: on_fault: expected"));
  EXPECT_THAT(refusal(two, {"on_fault=none"}), HasSubstr("--set: on_fault: expected"));
  for (const char* list : {"drive = []\n", "drive = [1, 2]\n"})
    EXPECT_THAT(refusal(list), HasSubstr("drives.toml:1: drive: expected [[drive]] tables, one to eight"));
}

TEST(DrivesConfig, AListIsRefusedWhereTheFileOfOneDriveIsExpected) {
  const ConfigFiles files;
  const std::string several = files.write("drives.toml", two);
  const std::string expected = "drive: a list of drives, where the file of one is expected";
  EXPECT_THAT(ecu_refusal(several), HasSubstr("drives.toml:1: " + expected));
  EXPECT_THAT(refusal("[[drive]]\nbase = \"" + several + "\"\n"), HasSubstr("drives.toml:1: " + expected));
  EXPECT_THROW((void)load_scenario_config(several), ConfigError);
}

}  // namespace
}  // namespace sextant
