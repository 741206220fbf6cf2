// A drive of the library and one of a file are the same drive: what neither gives follows by the rules of
// `resolved` in both.
#include "sextant/drive/drive_setup.hpp"

#include <algorithm>
#include <any>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/control/controller_list.hpp"
#include "sextant/drive/resolved.hpp"

namespace sextant {
namespace {

/// Every member, without the padding between them.
template <class Parameters>
std::array<std::byte, sizeof(Parameters)> bytes_of(Parameters p) {
  static_assert(std::is_trivially_copyable_v<Parameters>);
  __builtin_clear_padding(&p);
  std::array<std::byte, sizeof(Parameters)> bytes;
  std::memcpy(bytes.data(), &p, sizeof p);
  return bytes;
}

/// Bit for bit.
template <class Parameters>
testing::AssertionResult are_equal(const Parameters& library, const Parameters& file) {
  const auto a = bytes_of(library);
  const auto b = bytes_of(file);
  const auto differs = std::mismatch(a.begin(), a.end(), b.begin()).first;
  if (differs == a.end()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "byte " << differs - a.begin() << " of " << a.size() << " differs";
}

void expect_the_drive_of(const DriveConfig& file, const DriveSetup<>& setup) {
  ASSERT_EQ(setup.validate(), nullptr);
  const ResolvedDrive<> library = resolved(setup);
  EXPECT_EQ(library.validate(), nullptr);
  EXPECT_TRUE(are_equal(library.drive, file.drive));
  EXPECT_TRUE(are_equal(library.control, file.control));
}

/// Each method of the file has the parameters that follow from the setup, but for `direct_torque`, those of
/// its table by switching.
void expect_the_methods_of(const DriveConfig& file, const ControlBasis<>& basis,
                           const DirectTorqueController<>::Parameters& direct_torque) {
  const auto expect = [&]<class C>(const typename C::Parameters& library) {
    const auto& in_file = file.parameters<C>();
    EXPECT_TRUE(are_equal(library, in_file)) << C::name;
    EXPECT_EQ(library.validate(), nullptr) << C::name;
  };
  const auto expect_default = [&]<class C>() {
    if constexpr (std::is_same_v<C, DirectTorqueController<>>) {
      expect.template operator()<C>(direct_torque);
    } else {
      expect.template operator()<C>(default_parameters<C>(basis));
    }
  };
  const auto each = [&]<class... C>(std::tuple<C...>* /*list*/) {
    (expect_default.template operator()<C>(), ...);
  };
  each(static_cast<ControllerList<double>*>(nullptr));
  each(static_cast<CommissioningList<double>*>(nullptr));
}

/// configs/machines/paper_3hp.toml
InductionMachineParameters<> paper_machine(double inertia) {
  const double omega = 2.0 * std::numbers::pi * 50.0;
  return {.r_s = 0.435,
          .r_r = 0.816,
          .l_ls = 0.754 / omega,
          .l_lr = 0.754 / omega,
          .l_m = 26.13 / omega,
          .pole_pairs = 2,
          .inertia = inertia};
}

/// What configs/ecu.toml, ecu_foc.toml, ecu_hard.toml and ecu_hil.toml have in common.
DriveSetup<> shipped_setup(std::int32_t period_ns, double inertia) {
  DriveSetup<> setup;
  setup.basis.machine = paper_machine(inertia);
  setup.basis.period_ns = period_ns;
  setup.command.torque_limit = 150;
  setup.capability.torque = 150;
  setup.protection.over_current = 250;
  setup.protection.dc_over_voltage = 700;
  return setup;
}

/// Direct torque control of those files that have a table for it.
DirectTorqueController<>::Parameters shipped_direct_torque(const DriveSetup<>& setup) {
  auto p = default_parameters<DirectTorqueController<>>(resolved(setup).control);
  p.torque_comparator.upper_band = 0.918;
  p.torque_comparator.lower_band = 0.918;
  p.flux_comparator.band = 0.01;
  return p;
}

DriveConfig shipped(const std::string& name) {
  return load_ecu_config(SEXTANT_SOURCE_DIR "/configs/" + name).drive;
}

TEST(DriveSetup, MakesTheDrivesOfTheShippedFiles) {
  DriveSetup<> setup = shipped_setup(25'000, 0.5);
  setup.torque_monitor.limit = 10;
  const auto direct_torque = shipped_direct_torque(setup);
  for (const char* name : {"ecu.toml", "ecu_foc.toml"}) {
    SCOPED_TRACE(name);
    expect_the_drive_of(shipped(name), setup);
    expect_the_methods_of(shipped(name), resolved(setup).control, direct_torque);
  }
  {
    SCOPED_TRACE("ecu_hard.toml");
    setup = shipped_setup(250'000, 0.5);
    expect_the_drive_of(shipped("ecu_hard.toml"), setup);
    const ControlBasis<> basis = resolved(setup).control;
    expect_the_methods_of(shipped("ecu_hard.toml"), basis,
                          default_parameters<DirectTorqueController<>>(basis));
  }
  SCOPED_TRACE("ecu_hil.toml");
  setup = shipped_setup(100'000, 0.089);
  setup.basis.actuation_delay_periods = 1;
  setup.protection.flux_lost_ns = 10'000'000'000;
  expect_the_drive_of(shipped("ecu_hil.toml"), setup);
  expect_the_methods_of(shipped("ecu_hil.toml"), resolved(setup).control, shipped_direct_torque(setup));
}

/// A file that names machine, link and period only.
DriveConfig machine_alone(const std::string& machine, double u_dc, int period_us) {
  const ConfigFiles files;
  return load_ecu_config(
             files.write("ecu.toml", "machine = \"" SEXTANT_SOURCE_DIR "/configs/machines/" + machine +
                                         "\"\n[plant]\nu_dc_v = " + std::to_string(u_dc) +
                                         "\n[drive]\nperiod_us = " + std::to_string(period_us) + "\n"),
             {"control.controller=foc"})
      .drive;
}

TEST(DriveSetup, MakesTheDriveOfAMachineAloneByItsLinkAndPeriod) {
  const struct {
    const char* machine;
    double u_dc, frequency;
  } cases[] = {{"marathon_quarter_hp.toml", 311, 60},
               {"krause_50hp.toml", 651, 60},
               {"motulator_45k.toml", 566, 50},
               {"eight_pole_3k.toml", 311, 60}};
  for (const auto& x : cases) {
    for (const int period_us : {25, 125, 250}) {
      SCOPED_TRACE(testing::Message() << x.machine << " at " << period_us << " us");
      const DriveConfig file = machine_alone(x.machine, x.u_dc, period_us);
      DriveSetup<> setup;
      setup.basis.machine = file.plant.plant.machine;
      setup.basis.period_ns = period_us * 1000;
      setup.basis.u_dc = x.u_dc;
      setup.basis.flux_reference = flux_at_voltage_limit(x.u_dc, x.frequency);
      expect_the_drive_of(file, setup);
      const ControlBasis<> basis = resolved(setup).control;
      expect_the_methods_of(file, basis, default_parameters<DirectTorqueController<>>(basis));
    }
  }
}

/// A setup in which nothing has its default, and the keys of a file that say the same.
TEST(DriveSetup, SaysWhatTheKeysOfAFileSay) {
  DriveSetup<> s = shipped_setup(40'000, 0.5);
  s.basis.inverter = {.dead_time_ns = 1500,
                      .minimum_pulse = {2000, ShortPulses::stretched},
                      .threshold_voltage = 0.9,
                      .slope_resistance = 0.02};
  s.basis.sampling_lead_ns = 10'000;
  s.basis.actuation_delay_periods = 1;
  s.basis.u_dc = 560;
  s.basis.flux_reference = 0.9;
  s.voltage_error = 1.25;
  s.flux_estimator = FluxEstimatorKind::observer;
  s.adapts_parameters = false;
  s.magnetise_first = false;
  s.magnetise_timeout_ms = 1234.5;
  s.command = {.torque_limit = 90,
               .torque_rate = 5e4,
               .timeout_ns = 41'000'000,
               .zero_ramp_ns = 9'000'000,
               .lost_ns = 210'000'000,
               .status_timeout_ns = 70'000'000,
               .status_lost_ns = 310'000'000,
               .blocked_limit = 4};
  s.current_limit = 70;
  s.capability = {
      .torque = 80, .voltage_use = 0.9, .breakdown_use = 0.8, .base_speed = 90, .zero_torque_speed = 300};
  s.protection = {.over_current = 101,
                  .dc_over_voltage = 720,
                  .over_speed = 400,
                  .dc_under_voltage = 200,
                  .current_range = 900,
                  .voltage_range = 6000,
                  .speed_range = 4000,
                  .current_sum = 5,
                  .current_gain_tolerance = 0.04,
                  .current_offset = 0.7,
                  .current_jump = 9,
                  .current_response = 0.3,
                  .current_noise = 0.3,
                  .zero_current = 1.5,
                  .current_step = 0.1,
                  .speed_jump = 30,
                  .speed_error = 25,
                  .speed_error_ns = 5'000'000,
                  .flux_lost_share = 0.4,
                  .flux_lost_torque = 8,
                  .flux_lost_ns = 150'000'000,
                  .winding_warning = 120,
                  .winding_trip = 150,
                  .winding = {.nominal_current = 8, .nominal_rise = 70, .time_constant = 500, .ambient = 30}};
  s.torque_monitor = {.enabled = false,
                      .machine = {},
                      .limit = 12,
                      .limit_share = 0.06,
                      .wrong_sign = 4,
                      .time_ns = 11'000'000,
                      .r_s_share = 0.4,
                      .r_r_share = 0.45,
                      .l_m_share = 0.25,
                      .sensor_share = 0.04};
  s.torque_monitor.machine = s.basis.machine;
  s.torque_monitor.machine->r_s = 0.5;
  s.optimal_flux = {.optimum = FluxOptimum::min_loss, .least_share = 0.3, .iron_loss_resistance = 900};
  expect_the_drive_of(load_ecu_config(shipped_ecu, {"drive.period_us=40",
                                                    "drive.inverter.dead_time_us=1.5",
                                                    "drive.inverter.minimum_pulse_us=2",
                                                    "drive.inverter.short_pulses=stretched",
                                                    "drive.inverter.threshold_v=0.9",
                                                    "drive.inverter.slope_ohm=0.02",
                                                    "drive.inverter.voltage_error_v=1.25",
                                                    "drive.sampling_lead_us=10",
                                                    "drive.actuation_delay_periods=1",
                                                    "plant.u_dc_v=560",
                                                    "control.flux_reference_wb=0.9",
                                                    "control.flux_estimator=observer",
                                                    "control.adapts_parameters=false",
                                                    "drive.magnetise_first=false",
                                                    "drive.magnetise_timeout_ms=1234.5",
                                                    "command.torque_limit_nm=90",
                                                    "command.torque_rate_nm_s=5e4",
                                                    "command.timeout_ms=41",
                                                    "command.zero_ramp_ms=9",
                                                    "command.lost_ms=210",
                                                    "command.status_timeout_ms=70",
                                                    "command.status_lost_ms=310",
                                                    "command.blocked_limit=4",
                                                    "capability.torque_nm=80",
                                                    "drive.current_limit_a=70",
                                                    "capability.voltage_use=0.9",
                                                    "capability.breakdown_use=0.8",
                                                    "capability.base_speed_rad_s=90",
                                                    "capability.zero_torque_speed_rad_s=300",
                                                    "protection.over_current_a=101",
                                                    "protection.dc_over_voltage_v=720",
                                                    "protection.over_speed_rad_s=400",
                                                    "protection.dc_under_voltage_v=200",
                                                    "protection.current_range_a=900",
                                                    "protection.voltage_range_v=6000",
                                                    "protection.speed_range_rad_s=4000",
                                                    "protection.current_sum_a=5",
                                                    "protection.current_gain_tolerance=0.04",
                                                    "protection.current_offset_a=0.7",
                                                    "protection.current_jump_a=9",
                                                    "protection.current_response=0.3",
                                                    "protection.current_noise_a=0.3",
                                                    "protection.zero_current_a=1.5",
                                                    "protection.current_step_a=0.1",
                                                    "protection.speed_jump_rad_s=30",
                                                    "protection.speed_error_rad_s=25",
                                                    "protection.speed_error_ms=5",
                                                    "protection.flux_lost_share=0.4",
                                                    "protection.flux_lost_torque_nm=8",
                                                    "protection.flux_lost_ms=150",
                                                    "protection.winding.nominal_current_a=8",
                                                    "protection.winding.nominal_rise_k=70",
                                                    "protection.winding.time_constant_s=500",
                                                    "protection.winding.ambient_c=30",
                                                    "protection.winding.warning_c=120",
                                                    "protection.winding.trip_c=150",
                                                    "torque_monitor.enabled=false",
                                                    "torque_monitor.limit_nm=12",
                                                    "torque_monitor.limit_share=0.06",
                                                    "torque_monitor.wrong_sign_nm=4",
                                                    "torque_monitor.time_ms=11",
                                                    "torque_monitor.r_s_share=0.4",
                                                    "torque_monitor.r_r_share=0.45",
                                                    "torque_monitor.l_m_share=0.25",
                                                    "torque_monitor.sensor_share=0.04",
                                                    "torque_monitor.machine.r_s_ohm=0.5",
                                                    "drive.flux_optimum=min_loss",
                                                    "drive.flux_least_share=0.3",
                                                    "drive.iron_loss_resistance_ohm=900",
                                                    "control.controller=foc"})
                          .drive,
                      s);
}

}  // namespace
}  // namespace sextant
