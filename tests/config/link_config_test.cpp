// The DC link with capacitance: its keys reach each plant, and what contradicts itself is refused.
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

const Settings whole{"plant.link.capacitance_f=1e-3", "plant.link.source_ohm=0.2",
                     "plant.link.source_h=1e-4",      "plant.link.source_diode=true",
                     "plant.link.chopper_ohm=20",     "plant.link.chopper_on_v=650",
                     "plant.link.chopper_off_v=620",  "plant.link.initial_v=10",
                     "plant.link.precharge_ohm=40",   "plant.link.contactor_share=0.9"};

TEST(LinkConfig, IsStiffByDefault) {
  EXPECT_FALSE(load_scenario_config(shipped_scenario).drive.plant.link.acts());
  EXPECT_FALSE(load_ecu_config(shipped_ecu).drive.plant.link.acts());
  EXPECT_FALSE(load_plant_config(shipped_plant).plant.link.acts());
}

TEST(LinkConfig, EachKeyReachesItsOwnValueOfEachPlant) {
  const DcLinkParameters<> expected{1e-3, 0.2, 1e-4, true, 20, 650, 620, 10.0, 40, 0.9};
  EXPECT_EQ(load_scenario_config(shipped_scenario, whole).drive.plant.link, expected);
  EXPECT_EQ(load_plant_config(shipped_plant, whole).plant.link, expected);
  EXPECT_EQ(load_ecu_config(shipped_ecu, whole).drive.plant.link, expected);
}

TEST(LinkConfig, EachIntegratorMovesIt) {
  for (const char* integrator : {"cvode", "erk", "fixed", "exact"})
    EXPECT_EQ(ecu_refusal(shipped_ecu, with(whole, "plant.integrator", integrator)), "accepted");
}

TEST(LinkConfig, WhatMakesNoLinkIsRefused) {
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, with(whole, "plant.link.capacitance_f", "0")),
      HasSubstr("plant.link: a source with resistance, inductance or diode, a brake chopper and a pre-charge "
                "need a DC link with a capacitance above zero"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with(whole, "plant.link.source_ohm", "0")),
              HasSubstr("plant.link: the resistance of the source must be above zero"));
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, with(whole, "plant.link.chopper_on_v", "620")),
      HasSubstr("plant.link: the brake chopper must turn off at a voltage above zero and below that at "
                "which it turns on"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with(whole, "plant.link.chopper_ohm", "0")),
              HasSubstr("plant.link: the voltages of the brake chopper need a resistance of it above zero"));
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, with(whole, "plant.link.chopper_off_v", "530")),
      HasSubstr("plant: link.chopper_off_v must be above u_dc_v, or the brake chopper loads the source"));
}

TEST(LinkConfig, AFaultOfAContactorNeedsOne) {
  for (const char* kind : {"contactor_open", "contactor_welded"}) {
    const Settings broken = with(whole, "plant.faults.kind", kind);
    EXPECT_EQ(ecu_refusal(shipped_ecu, broken), "accepted");
    Settings without = with(broken, "plant.link.precharge_ohm", "0");
    without = with(without, "plant.link.contactor_share", "0.95");
    EXPECT_THAT(ecu_refusal(shipped_ecu, without),
                HasSubstr("plant: faults.kind is of the main contactor, which there is with"));
  }
}

TEST(LinkConfig, ALinkThatTakesTooManyStepsIsRefused) {
  Settings fast = with(whole, "plant.link.capacitance_f", "1e-9");
  fast.push_back("plant.integrator=fixed");
  EXPECT_THAT(ecu_refusal(shipped_ecu, fast),
              HasSubstr("capacitance, resistances or inductance of [plant.link] are too small; integrator = "
                        "\"cvode\" with cvode.method = \"bdf\" is for stiff links"));
  fast.back() = "plant.integrator=cvode";
  EXPECT_EQ(ecu_refusal(shipped_ecu, fast), "accepted");
}

TEST(LinkConfig, IsNoneOfAnEventExactRun) {
  EXPECT_THAT(
      scenario_refusal({"mode=event_exact", "plant.link.capacitance_f=1e-3", "plant.link.source_ohm=0.2"}),
      HasSubstr("an event-exact run has a stiff DC link, plant.link.capacitance_f must be 0"));
}

TEST(LinkConfig, IsThatOfThePlantInAnotherProcess) {
  EXPECT_THAT(ecu_refusal(shipped_ecu_hil, {"plant.link.capacitance_f=1e-3", "plant.link.source_ohm=0.2"}),
              HasSubstr("the DC link is that of the plant outside this process: set plant.link there"));
}

TEST(LinkConfig, ThePowerStageRefusesALinkThatIsNotItsOwn) {
  SimulatedPowerStageParameters p{.integrator = IntegratorKind::fixed};
  EXPECT_THROW((LinkedPowerStage{p, {}}), std::runtime_error);
  p.link = {1e-3, 0.2};
  EXPECT_EQ(p.validate(), nullptr);
  EXPECT_THROW((SimulatedPowerStage{p, {}}), std::runtime_error);
  p.link = {1e-3, 0.2, 0, false, 20, 650, 500};
  EXPECT_THAT(p.validate(), HasSubstr("or it loads the source"));
}

}  // namespace
}  // namespace sextant
