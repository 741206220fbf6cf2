// The losses of the inverter: their keys reach each plant, and what contradicts itself is refused.
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

const Settings whole{"plant.inverter.losses.switch_v=[[0, 0.8], [75, 1.9]]",
                     "plant.inverter.losses.switch_hot_v=[[0, 0.7], [75, 2.3]]",
                     "plant.inverter.losses.diode_v=[[0, 0.9], [75, 1.7]]",
                     "plant.inverter.losses.diode_hot_v=[[0, 0.8], [75, 1.6]]",
                     "plant.inverter.losses.turn_on_mj=[[0, 0], [75, 8]]",
                     "plant.inverter.losses.turn_on_hot_mj=[[0, 0], [75, 16]]",
                     "plant.inverter.losses.turn_off_mj=[[0, 0], [75, 4]]",
                     "plant.inverter.losses.turn_off_hot_mj=[[0, 0], [75, 6]]",
                     "plant.inverter.losses.recovery_mj=[[0, 0], [75, 2]]",
                     "plant.inverter.losses.recovery_hot_mj=[[0, 0], [75, 5]]",
                     "plant.inverter.losses.cold_c=20",
                     "plant.inverter.losses.hot_c=150",
                     "plant.inverter.losses.energy_voltage_v=300",
                     "plant.inverter.losses.switch_exponent=1.2",
                     "plant.inverter.losses.diode_exponent=0.5",
                     "plant.inverter.losses.switch_network=[[0.1, 0.01], [0.2, 0.05]]",
                     "plant.inverter.losses.diode_network=[[0.3, 0.02]]",
                     "plant.inverter.losses.case_network=[[0.04, 30]]",
                     "plant.inverter.losses.ambient_c=45",
                     "plant.inverter.losses.case_c=70"};

Settings with(const std::string& setting) {
  Settings settings = whole;
  settings.push_back("plant.inverter.losses." + setting);
  return settings;
}

TEST(InverterLossConfig, EachKeyReachesItsOwnValueOfEachPlant) {
  InverterLossParameters p;
  p.switch_voltage = {{{0, 0.8}, {75, 1.9}}, {{0, 0.7}, {75, 2.3}}};
  p.diode_voltage = {{{0, 0.9}, {75, 1.7}}, {{0, 0.8}, {75, 1.6}}};
  p.turn_on = {{{0, 0}, {75, 8e-3}}, {{0, 0}, {75, 16e-3}}};
  p.turn_off = {{{0, 0}, {75, 4e-3}}, {{0, 0}, {75, 6e-3}}};
  p.recovery = {{{0, 0}, {75, 2e-3}}, {{0, 0}, {75, 5e-3}}};
  p.cold = 20;
  p.hot = 150;
  p.energy_voltage = 300;
  p.switch_exponent = 1.2;
  p.diode_exponent = 0.5;
  p.switch_network = {{0.1, 0.01}, {0.2, 0.05}};
  p.diode_network = {{0.3, 0.02}};
  p.case_network = {{0.04, 30}};
  p.ambient = 45;
  p.start_case = 70;
  EXPECT_EQ(load_scenario_config(shipped_scenario, whole).drive.plant.losses, p);
  EXPECT_EQ(load_plant_config(shipped_plant, whole).plant.losses, p);
  EXPECT_EQ(load_ecu_config(shipped_ecu, whole).drive.plant.losses, p);
  EXPECT_FALSE(load_ecu_config(shipped_ecu).drive.plant.losses.acts());
}

TEST(InverterLossConfig, TheShippedFileIsTaken) {
  const Settings file{"plant.inverter.losses=" + std::string{SEXTANT_SOURCE_DIR} +
                      "/configs/inverters/typical_1200v_75a.toml"};
  const InverterLossParameters p = load_scenario_config(shipped_scenario, file).drive.plant.losses;
  EXPECT_TRUE(p.acts());
  EXPECT_EQ(p.switch_network.size(), 4U);
}

TEST(InverterLossConfig, WhatMakesNoLossesIsRefused) {
  const std::string table = "plant.inverter.losses: ";
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.inverter.losses.ambient_c=30"}),
              HasSubstr(table + "networks, temperatures and voltages of the inverter's losses need a curve"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with("turn_on_mj=[[5, 1], [5, 2]]")),
              HasSubstr(table + "the currents of a curve must rise from point to point"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with("diode_v=[[5, 1]]")),
              HasSubstr(table + "a curve over the current needs two points at least"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with("hot_c=20")), HasSubstr(table + "hot_c must be above cold_c"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, with("case_network=[[0, 1]]")),
              HasSubstr(table + "resistances and time constants of a Foster network must be"));
}

TEST(InverterLossConfig, ARefusedListNamesItsOwnMembers) {
  const auto refused = [](const std::string& key) {
    return ecu_refusal(shipped_ecu, {"plant.inverter.losses." + key + "=[[-1, -1]]"});
  };
  EXPECT_THAT(
      refused("switch_hot_v"),
      HasSubstr("a list of [current, voltage] pairs, current from 0 to 100000, voltage from 0 to 1000"));
  EXPECT_THAT(refused("turn_on_mj"), HasSubstr("a list of [current, energy] pairs, current from 0 to"));
  EXPECT_THAT(refused("case_network"),
              HasSubstr("a list of [resistance, time constant] pairs, resistance from 0 to"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"load.torque_nm.points=3"}),
              HasSubstr("a list of [time, value] pairs, time from 0 to"));
}

TEST(InverterLossConfig, IsNoneOfAnEventExactRunOrAPlantInAnotherProcess) {
  Settings settings = whole;
  settings.emplace_back("mode=event_exact");
  try {
    (void)load_scenario_config(shipped_scenario, settings);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("plant.inverter.losses must have no curve"));
  }
  EXPECT_THAT(ecu_refusal(shipped_ecu_hil, whole), HasSubstr("set plant.inverter.losses there"));
}

}  // namespace
}  // namespace sextant
