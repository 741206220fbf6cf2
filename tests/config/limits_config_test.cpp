// Limits that a file does not name follow from machine and link.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/control/predictive_controller.hpp"
#include "sextant/core/drive_limits.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

using testing::HasSubstr;

/// A traction machine of 200 kW, or one of 250 W.
const std::string large =
    "r_s_ohm = 0.012\nr_r_ohm = 0.009\nl_ls_h = 1.4e-4\nl_lr_h = 1.6e-4\nl_m_h = 5.2e-3\npoles = 6\n"
    "inertia_kg_m2 = 4\n";
const std::string small =
    "r_s_ohm = 25\nr_r_ohm = 22\nl_ls_h = 0.06\nl_lr_h = 0.06\nl_m_h = 1.1\npoles = 4\n"
    "inertia_kg_m2 = 3e-4\n";

template <class C>
double trim_of(const DriveConfig& c) {
  return c.parameters<C>().torque_trim.time_constant;
}

class LimitsConfig : public testing::Test {
 protected:
  [[nodiscard]] std::string own(const std::string& machine, const std::string& rest) const {
    (void)files_.write("own.toml", machine);
    return files_.write("ecu.toml", "machine = \"own.toml\"\n" + rest);
  }
  [[nodiscard]] static std::string refusal(const std::string& file,
                                           const std::vector<std::string>& overrides = {}) {
    try {
      (void)load_ecu_config(file, overrides);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }
  ConfigFiles files_{};
};

TEST_F(LimitsConfig, OfAnOwnMachineAreItsOwn) {
  const struct {
    const std::string& machine;
    double psi;
    double u_dc;
  } cases[] = {{large, 0.9, 560}, {small, 0.9, 540}, {small, 0.3, 200}};
  for (const auto& x : cases) {
    SCOPED_TRACE(x.machine);
    const std::string file = own(x.machine, "[control]\nflux_reference_wb = " + std::to_string(x.psi) +
                                                "\n[plant]\nu_dc_v = " + std::to_string(x.u_dc) + "\n");
    const DriveConfig c = load_ecu_config(file).drive;
    const InductionMachineParameters<>& m = c.plant.plant.machine;
    EXPECT_EQ(c.drive.motor.capability.machine.l_m, m.l_m);
    EXPECT_EQ(c.drive.motor.capability.flux_reference, x.psi);
    const double breakdown =
        0.75 * m.pole_pairs * m.l_m * m.l_m / (m.l_s() * m.l_r() * m.sigma_l_s()) * x.psi * x.psi;
    EXPECT_NEAR(c.drive.command.torque_limit, 0.4 * breakdown, 1e-9 * breakdown);
    EXPECT_EQ(c.drive.motor.capability.torque, c.drive.command.torque_limit);
    EXPECT_NEAR(c.drive.protection.dc_over_voltage, 1.3 * x.u_dc, 1e-9);
    EXPECT_NEAR(c.direct_torque().magnetiser.current_limit, 1.8 * x.psi / m.l_s(), 1e-9);
    EXPECT_NEAR(c.direct_torque().flux_comparator.band, 0.01 * x.psi, 1e-12);
    // A quarter of what a vector changes in a period of 25 µs, or less than that.
    const double step = m.pole_pairs * x.psi * x.u_dc * 25e-6 / m.sigma_l_s();
    const double band = std::max(0.0025 * breakdown, step / 4);
    EXPECT_NEAR(c.direct_torque().torque_comparator.upper_band, band, 1e-9 * breakdown);
    EXPECT_NEAR(c.direct_torque().torque_comparator.lower_band, band, 1e-9 * breakdown);
    EXPECT_NEAR(c.drive.protection.over_speed, 3.5 * x.u_dc / std::sqrt(3.0) / (m.pole_pairs * x.psi),
                0.1 * c.drive.protection.over_speed)
        << "but for the drop in the resistance";
    EXPECT_GT(c.drive.protection.over_current, steady_state(m, x.psi, 1.0).current());
    EXPECT_NEAR(c.drive.motor.capability.current_limit, 0.8 * c.drive.protection.over_current, 1e-9);
    const double slip = relative_slip(c.drive.command.torque_limit, breakdown);
    EXPECT_GT(c.drive.motor.capability.current_limit, 1.5 * steady_state(m, x.psi, slip).current());
  }
}

// 530 V move 4 % of 1.1 Wb in 125 µs, five times that of 25 µs.
TEST_F(LimitsConfig, OfWholeVectorsGoWithThePeriodWhereTheFileNamesNone) {
  for (const double times : {1.0, 5.0}) {
    const std::string file = files_.write(
        "ecu.toml",
        "machine = \"" + shipped_machine + "\"\n[control]\nflux_reference_wb = 1.1\n[drive]\nperiod_us = " +
            std::to_string(25 * times) + "\n[plant]\nu_dc_v = 530\n[realtime]\nwake_every_periods = 1\n");
    const DriveConfig c = load_ecu_config(file).drive;
    const double step = 6.16 * times;
    EXPECT_NEAR(c.direct_torque().torque_comparator.upper_band, step / 4, 0.02 * step);
    EXPECT_NEAR(trim_of<DirectTorqueController<>>(c), 0.01 / times, 1e-4 / times);
    EXPECT_NEAR(trim_of<PredictiveController<>>(c), 0.01 / times, 1e-4 / times);
    EXPECT_EQ(trim_of<DutyRatioController<>>(c), 0.01);
  }
}

TEST_F(LimitsConfig, StandWhereTheFileNamesThem) {
  const std::string file =
      own(large,
          "[control]\nflux_reference_wb = 0.9\n[control.dtc]\ntorque_band_upper_nm = 3\ntorque_band_lower_nm "
          "= 4\n"
          "flux_band_wb = 0.02\nmagnetising_current_a = 900\nhand_over_current_a = 800\n"
          "[command]\ntorque_limit_nm = 700\n[capability]\ntorque_nm = 600\n[protection]\n"
          "over_current_a = 1234\ndc_over_voltage_v = 810\nover_speed_rad_s = 333\n");
  const DriveConfig c = load_ecu_config(file).drive;
  EXPECT_EQ(c.direct_torque().flux_reference, 0.9);
  EXPECT_EQ(c.direct_torque().torque_comparator.upper_band, 3);
  EXPECT_EQ(c.direct_torque().torque_comparator.lower_band, 4);
  EXPECT_EQ(c.direct_torque().flux_comparator.band, 0.02);
  EXPECT_EQ(c.direct_torque().magnetiser.current_limit, 900);
  EXPECT_EQ(c.direct_torque().magnetiser.hand_over_current, 800);
  EXPECT_EQ(c.drive.command.torque_limit, 700);
  EXPECT_EQ(c.drive.motor.capability.torque, 600);
  EXPECT_EQ(c.drive.protection.over_current, 1234);
  EXPECT_NEAR(c.drive.motor.capability.current_limit, 0.8 * 1234, 1e-9);
  EXPECT_EQ(c.drive.protection.dc_over_voltage, 810);
  EXPECT_EQ(c.drive.protection.over_speed, 333);
}

TEST_F(LimitsConfig, FollowTheControllersIdeaOfTheMachine) {
  const DriveConfig c = load_ecu_config(shipped_ecu, {"control.machine_estimate.l_m_h=0.07"}).drive;
  EXPECT_EQ(c.drive.motor.capability.machine.l_m, 0.07);
  EXPECT_NE(c.plant.plant.machine.l_m, 0.07);
}

TEST_F(LimitsConfig, NoShippedDriveAnnouncesMoreThanItsVoltageAllows) {
  for (const char* name : {"ecu.toml", "ecu_foc.toml", "ecu_hil.toml", "ecu_hard.toml"}) {
    SCOPED_TRACE(name);
    const DriveConfig c = load_ecu_config(SEXTANT_SOURCE_DIR "/configs/" + std::string{name}).drive;
    const TorqueCapability<> capability{c.drive.motor.capability};
    EXPECT_EQ(capability.at(50.0, 530.0).motoring.torque, 150.0);
    EXPECT_LE(capability.at(140.0, 530.0).motoring.torque, 140.0);
    EXPECT_LE(capability.at(400.0, 530.0).motoring.torque, 28.6);
    EXPECT_LE(capability.at(400.0, 530.0).regenerating.torque, 66.1);
    EXPECT_NEAR(c.drive.protection.over_speed, 487.0, 0.5);
  }
}

TEST_F(LimitsConfig, TheFluxFollowsFromLinkAndFrequencyOrHasToBeSaid) {
  const std::string with_frequency = own(large + "reactance_frequency_hz = 60\n", "[plant]\nu_dc_v = 600\n");
  EXPECT_NEAR(load_ecu_config(with_frequency).drive.direct_torque().flux_reference,
              600.0 / std::sqrt(3.0) / (2.0 * std::acos(-1.0) * 60.0), 1e-12);
  const std::string without = own(large, "");
  EXPECT_THAT(refusal(without),
              HasSubstr(without + ": control.flux_reference_wb: missing: the machine names no "
                                  "reactance_frequency_hz"));
}

// What a wrong value makes of the values that follow from it is not said beside it.
TEST_F(LimitsConfig, OneWrongValueOfTheMachineOrTheLinkGivesOneComplaint) {
  const struct {
    const char* key;
    const char* value;
    const char* said;
  } cases[] = {
      {"machine.l_m_h", "5.2", "machine: the magnetising inductance, 5.2 H, is 17330 times the leakage"},
      {"machine.l_m_h", "5.2e-6", "machine: the magnetising inductance, 5.2e-06 H, is 0.01733 times"},
      {"machine.l_ls_h", "0.14", "machine: the magnetising inductance, 0.0052 H, is 0.0371 times"},
      {"machine.l_lr_h", "0.16", "machine: the magnetising inductance"},
      {"machine.reactance_frequency_hz", "0.06", "control.flux_reference_wb: missing"},
      {"machine.r_s_ohm", "1e4", ""},
      {"plant.u_dc_v", "1", ""},
      {"protection.over_current_a", "0.1", ""},
      {"control.flux_reference_wb", "10", "command.torque_limit_nm: missing: no usable value follows"},
  };
  const std::string file = own(large + "reactance_frequency_hz = 60\n", "[plant]\nu_dc_v = 600\n");
  for (const auto& x : cases) {
    SCOPED_TRACE(x.key);
    const std::string why = refusal(file, {std::string{x.key} + "=" + x.value});
    EXPECT_EQ(std::count(why.begin(), why.end(), '\n'), 0) << why;
    EXPECT_THAT(why, HasSubstr(x.said));
    EXPECT_NE(why, "accepted");
  }
}

TEST_F(LimitsConfig, AFluxThatTheLinkCannotFeedIsRefused) {
  const std::string file = own(small, "[control]\nflux_reference_wb = 0.9\n[plant]\nu_dc_v = 30\n");
  EXPECT_THAT(refusal(file), HasSubstr(file + ":2: control: the link cannot feed flux_reference_wb even at "
                                              "standstill: lower it or raise plant.u_dc_v"));
}

TEST_F(LimitsConfig, TheCurrentLimitIsBelowTheTripAndAboveTheCurrentOfTheFlux) {
  EXPECT_THAT(refusal(shipped_ecu, {"drive.current_limit_a=250"}),
              HasSubstr("drive: current_limit_a must be below protection.over_current_a"));
  EXPECT_THAT(refusal(shipped_ecu, {"drive.current_limit_a=19"}),
              HasSubstr("capability: the current limit must be above 1.5 times the current that the flux "
                        "takes without torque"));
  EXPECT_EQ(
      load_ecu_config(shipped_ecu, {"drive.current_limit_a=40"}).drive.drive.motor.capability.current_limit,
      40);
}

TEST_F(LimitsConfig, MoreThanTheLinearVoltageNeedsAMethodThatReachesIt) {
  EXPECT_THAT(refusal(shipped_ecu, {"capability.voltage_use=1.05"}),
              HasSubstr("capability: voltage_use above 1 needs a modulated method with overmodulation "
                        "\"fundamental\", which \"dtc\" is not: choose one, or voltage_use of 1 at most"));
  EXPECT_THAT(refusal(shipped_ecu, {"capability.voltage_use=1.05", "control.controller=foc"}),
              HasSubstr("which \"foc\" is not"));
  EXPECT_EQ(load_ecu_config(shipped_ecu, {"capability.voltage_use=1.05", "control.controller=foc",
                                          "control.foc.overmodulation=fundamental"})
                .drive.drive.motor.capability.voltage_use,
            1.05);
}

TEST_F(LimitsConfig, ATypedCurveNeedsItsEnd) {
  EXPECT_THAT(refusal(shipped_ecu, {"capability.base_speed_rad_s=80"}),
              HasSubstr("capability: a base speed needs a zero-torque speed"));
  const DriveConfig c = load_ecu_config(shipped_ecu, {"capability.base_speed_rad_s=80",
                                                      "capability.zero_torque_speed_rad_s=100"})
                            .drive;
  EXPECT_EQ(c.drive.motor.capability.base_speed, 80);
  EXPECT_EQ(c.drive.motor.capability.zero_torque_speed, 100);
}

TEST_F(LimitsConfig, TheFluxIsConstantUnlessItsOptimumIsAskedFor) {
  const OptimalFlux<>::Parameters by_default = load_ecu_config(shipped_ecu).drive.drive.motor.optimal_flux;
  EXPECT_EQ(by_default.optimum, FluxOptimum::constant);
  EXPECT_TRUE(std::isinf(by_default.iron_loss_resistance));
  const OptimalFlux<>::Parameters asked =
      load_ecu_config(shipped_ecu, {"drive.flux_optimum=min_loss", "drive.flux_least_share=0.3",
                                    "drive.iron_loss_resistance_ohm=900"})
          .drive.drive.motor.optimal_flux;
  EXPECT_EQ(asked.optimum, FluxOptimum::min_loss);
  EXPECT_EQ(asked.least_share, 0.3);
  EXPECT_EQ(asked.iron_loss_resistance, 900);
  EXPECT_EQ(load_ecu_config(shipped_ecu, {"drive.flux_optimum=max_torque_per_ampere"})
                .drive.drive.motor.optimal_flux.optimum,
            FluxOptimum::max_torque_per_ampere);
}

TEST_F(LimitsConfig, ArePrintedWithTheirOrigin) {
  const std::string text = print_config(load_ecu_config(shipped_ecu));
  EXPECT_THAT(text, HasSubstr("torque_limit_nm = 150 "));
  EXPECT_THAT(text, testing::ContainsRegex("over_speed_rad_s = 486[.][0-9]+  # [^\n]*default derived from "
                                           "machine and link\n"));
  EXPECT_THAT(text, HasSubstr("# base_speed_rad_s = "));
}

// (2/3) 560 V 125 us/(295 uH) = 158 A; 0.9 Wb/(15 x 295 uH) = 204 A. A fifth of the flux as its reference: 41
// A.
TEST_F(LimitsConfig, AVectorThatIsTooLongForTheTableIsRefusedWithBothNumbers) {
  const auto drive = [this](const char* psi, const char* method, int period_us) {
    return own(large, "[control]\ncontroller = \"" + std::string{method} + "\"\nflux_reference_wb = " + psi +
                          "\n[plant]\nu_dc_v = 560\n[drive]\nperiod_us = " + std::to_string(period_us) +
                          "\n[realtime]\nwake_every_periods = 1\n");
  };
  EXPECT_EQ(refusal(drive("0.9", "dtc", 125)), "accepted");
  const std::string refused = refusal(drive("0.18", "dtc", 125));
  EXPECT_THAT(refused, HasSubstr("control.dtc"));
  EXPECT_THAT(refused, HasSubstr("moves the current by 158.1 A, more than 40.6 A"));
  EXPECT_THAT(refused, HasSubstr("drive.period_us may be 32 us at most"));
  EXPECT_EQ(refusal(drive("0.18", "dtc", 32)), "accepted");
  for (const char* other : {"predictive", "duty_ratio"}) {
    EXPECT_EQ(refusal(drive("0.18", other, 250)), "accepted");
  }
}

}  // namespace
}  // namespace sextant
