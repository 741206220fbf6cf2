#include "sextant/config/own_power_stage.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "support/own_power_stages.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Settings = std::vector<std::string>;

EcuExtensions own() {
  return {.power_stages = {own_power_stage<elsewhere::Inverter>(), own_power_stage<elsewhere::Model>()}};
}

Settings chosen(Settings more = {}) {
  more.insert(more.begin(), {"power_stage=inverter", "realtime.wake_every_periods=1"});
  return more;
}

EcuConfig load(const Settings& settings) {
  return load_ecu_config(shipped_ecu, settings, own());
}

std::string refusal(const Settings& settings) {
  try {
    (void)load(settings);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(OwnPowerStage, IsChosenByNameAndReadsItsTable) {
  const EcuConfig c = load(chosen({"inverter.scale=3", "drive.period_us=50"}));
  EXPECT_EQ(c.power_stage_kind(), PowerStageKind::own);
  const auto& p = dynamic_cast<const OwnPowerStageOf<elsewhere::Inverter>&>(c.own_power_stage()).values;
  EXPECT_EQ(p.scale, 3);
  EXPECT_EQ(p.period_ns, 50'000) << "shared with the drive";
  EXPECT_EQ(c.own_power_stage().open()->read(0).u_dc, 3);
}

TEST(OwnPowerStage, OfEachDriveHasItsOwnParameters) {
  const ConfigFiles files;
  const std::string table = "[[drive]]\nbase = \"" + shipped_ecu + "\"\npower_stage = \"inverter\"\n";
  const auto drive = [&](int k) {
    const std::string n = std::to_string(k);
    return table + "drive_id = " + n + "\ncan.identifier_offset = " + std::to_string(32 * k) +
           "\nrealtime.wake_every_periods = 1\ninverter.scale = " + n + "\n";
  };
  const DrivesConfig c = load_drives_config(files.write("drives.toml", drive(1) + drive(2)), {}, own());
  ASSERT_EQ(c.drives.size(), 2U);
  for (const int k : {0, 1})
    EXPECT_EQ(c.drives.at(std::size_t(k)).own_power_stage().open()->read(0).u_dc, k + 1);
}

TEST(OwnPowerStage, IsPrintedWithItsDefaultsAndReadBack) {
  const ConfigFiles files;
  const std::string text = print_config(load(chosen({"inverter.scale=3"})));
  EXPECT_THAT(text,
              HasSubstr("power_stage = \"inverter\"  # a plant in this process, in another one of this "
                        "machine, or on another machine; inverter: hardware of this test; model: a model of "
                        "this test; \"simulated\" or \"shared_memory\" or \"udp\" or \"inverter\" or "
                        "\"model\"; default \"simulated\"\n"));
  EXPECT_THAT(
      text,
      HasSubstr("\n[inverter]\nscale = 3  # of the link voltage [V]; a number from 0 to 10; default 2\n"));
  EXPECT_EQ(print_config(load_ecu_config(files.write("printed.toml", text), {}, own())), text);
  EXPECT_EQ(print_config(load_ecu_config_text(text, "text", {}, own())), text);
}

TEST(OwnPowerStage, IsRefusedByItsKeysAndItsOwnCheck) {
  EXPECT_THAT(refusal(chosen({"inverter.scale=11"})),
              HasSubstr("inverter.scale: expected a number from 0 to 10"));
  EXPECT_THAT(refusal(chosen({"inverter.scael=1"})), HasSubstr("inverter.scale"));
  EXPECT_THAT(refusal(chosen({"drive.period_us=125"})),
              HasSubstr("inverter: the scale is too high for the period"));
  EXPECT_EQ(refusal({"drive.period_us=125", "realtime.wake_every_periods=8", "control.controller=foc"}),
            "accepted")
      << "while it is not chosen";
}

TEST(OwnPowerStage, DoesNotWaitUnlessItSaysSo) {
  EXPECT_THAT(refusal({"power_stage=inverter"}), HasSubstr("realtime.wake_every_periods must be 1"));
  EXPECT_EQ(refusal({"power_stage=model"}), "accepted");
  EXPECT_TRUE(load({"power_stage=model"}).waits_for_drive());
  EXPECT_FALSE(load(chosen()).waits_for_drive());
}

TEST(OwnPowerStage, LeavesTheSimulatedPlantOut) {
  EXPECT_THAT(refusal(chosen({"plant.initial_speed_rad_s=10"})), HasSubstr("leaves the simulated plant out"));
  EXPECT_THAT(refusal(chosen({"plant.measures_angle=true"})), HasSubstr("leaves the simulated plant out"));
}

TEST(OwnPowerStage, NeedsANameOfItsOwn) {
  struct Named : OwnPowerStage {
    explicit Named(const char* given) : given_{given} {}
    [[nodiscard]] const char* name() const noexcept override { return given_; }
    [[nodiscard]] const char* meaning() const noexcept override { return ""; }
    [[nodiscard]] bool waits_for_drive() const noexcept override { return false; }
    void describe_table(Section, const DriveBasis<double>&) override {}
    [[nodiscard]] std::unique_ptr<DriveIo<double>> open() const override { return nullptr; }
    [[nodiscard]] std::unique_ptr<OwnPowerStage> clone() const override {
      return std::make_unique<Named>(*this);
    }
    [[nodiscard]] std::unique_ptr<OwnPowerStage> untouched() const override { return clone(); }
    const char* given_;
  };
  const auto named = [](const char* name) { return Cloned<OwnPowerStage>{std::make_unique<Named>(name)}; };
  for (const char* name :
       {"", "my inverter", "simulated", "udp", "hil", "control", "load", "drive_id", "base", "on_fault"})
    EXPECT_THROW((void)checked({named(name)}), std::invalid_argument) << name;
  EXPECT_THROW((void)checked({named("mine"), named("mine")}), std::invalid_argument);
  EXPECT_EQ(checked({named("mine"), named("my-other_1")}).size(), 2U);
}

}  // namespace
}  // namespace sextant
