#include "sextant/config/drives_config.hpp"

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
  EXPECT_EQ(loaded("on_fault = \"all_shut_down\"\n" + two, {"on_fault=others_go_on"}).on_fault,
            OnFault::others_go_on);
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

TEST(DrivesConfig, WhatExcludesEachOtherIsRefusedByKeyAndDrives) {
  const std::string same = "can.identifier_offset is the same for the drives 1 and 2";
  EXPECT_THAT(refusal(drive("drive_id = 1\n") + drive("drive_id = 2\n")), HasSubstr(same));
  EXPECT_THAT(refusal(two, {"drive_id=3"}), HasSubstr("drive_id is the same for the drives 1 and 2"));
  EXPECT_THAT(refusal(two, {"realtime.cpu=1"}), HasSubstr("realtime.cpu is the same for the drives 1 and 2"));
  EXPECT_THAT(refusal(two + "can.bus = \"socketcan:can7\"\n"), HasSubstr("can.bus differs"));
  EXPECT_THAT(refusal(two + "dds.domain = 3\n"), HasSubstr("dds.domain differs"));
  std::string nine;
  for (int k = 0; k < 9; ++k) {
    nine += drive("drive_id = " + std::to_string(k) + "\ncan.identifier_offset = " + std::to_string(32 * k) +
                  "\n");
  }
  EXPECT_THAT(refusal(nine), HasSubstr("drives.toml:1: drive: a process has at most 8 drives, here are 9"));
}

TEST(DrivesConfig, AWrongKeyIsRefusedAtItsLine) {
  EXPECT_THAT(refusal(two + "drive.period_is = 3\n"),
              HasSubstr("drives.toml:8: drive.period_is: unknown key"));
  EXPECT_THAT(refusal("drive_id = 1\n" + two), HasSubstr("drives.toml:1: drive_id: unknown key"));
  EXPECT_THAT(refusal("on_fault = \"none\"\n" + two), HasSubstr("drives.toml:1: on_fault: expected"));
  EXPECT_THAT(refusal(two, {"on_fault=none"}), HasSubstr("--set: on_fault: expected"));
  EXPECT_THAT(refusal("drive = []\n"), HasSubstr("drive: expected a table, got a list"));
}

}  // namespace
}  // namespace sextant
