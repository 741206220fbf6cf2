#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ecu/unit/power_stage.hpp"
#include "support/own_power_stages.hpp"

namespace sextant::ecu {
namespace {

EcuConfig with(Cloned<OwnPowerStage> own) {
  EcuConfig config;
  config.power_stage = own->name();
  config.own_power_stages = {std::move(own)};
  return config;
}

TEST(OwnPowerStage, IsTheDriveIoOfTheDriveWithItsParameters) {
  PowerStage stage{with(own_power_stage<elsewhere::Inverter>())};
  EXPECT_EQ(stage.io().read(0).u_dc, 2.0);
}

TEST(OwnPowerStage, GetsWhatTheOtherThreadsOfADriveAskFor) {
  PowerStage stage{with(own_power_stage<elsewhere::Inverter>())};
  auto& inverter = dynamic_cast<elsewhere::Inverter&>(stage.io());
  stage.inhibit_gates();
  EXPECT_EQ(inverter.inhibitions, 1);
  EXPECT_EQ(stage.problem(), "");
  inverter.is_lost = true;
  EXPECT_EQ(stage.problem(), "power_stage: \"inverter\" has lost its FPGA");
  stage.announce_end();
  EXPECT_TRUE(inverter.has_ended);
}

TEST(OwnPowerStage, NeedsNothingBesideADriveIo) {
  PowerStage stage{with(own_power_stage<elsewhere::Model>())};
  stage.inhibit_gates();
  stage.announce_end();
  EXPECT_EQ(stage.problem(), "");
  EXPECT_EQ(stage.state_change(), "");
}

TEST(OwnPowerStage, ThatCannotBeOpenedEndsTheStartWithItsSentence) {
  auto own = std::make_unique<OwnPowerStageOf<elsewhere::Inverter>>();
  own->values.scale = 5;
  const EcuConfig config = with(Cloned<OwnPowerStage>{std::move(own)});
  EXPECT_THAT([&] { PowerStage{config}; },
              testing::ThrowsMessage<std::runtime_error>("inverter.scale: /dev/inverter5 is not there"));
}

}  // namespace
}  // namespace sextant::ecu
