#include "sextant/drive/resolved.hpp"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

template <class T>
class ResolvedOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(ResolvedOf, Scalars);

TYPED_TEST(ResolvedOf, CountsATimeInWholeNanoseconds) {
  using T = TypeParam;
  EXPECT_EQ(whole_ns(T(0)), 0);
  EXPECT_EQ(whole_ns(T(0.25)), 250'000);
  EXPECT_EQ(whole_ns(T(1234.5)), 1'234'500'000);
  EXPECT_EQ(whole_ns(T(1e6)), 1'000'000'000'000);
  EXPECT_EQ(whole_ns(T(1e30)), 2'000'000'000'000'000);
  EXPECT_EQ(whole_ns(std::numeric_limits<T>::infinity()), 2'000'000'000'000'000);
}

TYPED_TEST(ResolvedOf, ATimeoutThatIsNoneIsRefused) {
  using T = TypeParam;
  for (const T time : {std::numeric_limits<T>::quiet_NaN(), T(0), T(-1), T(-1e30)}) {
    DriveSetup<T> setup;
    setup.magnetise_timeout_ms = time;
    EXPECT_EQ(whole_ns(time), 0) << time;
    EXPECT_STREQ(resolved(setup).validate(), "the time for magnetising must be above zero") << time;
  }
}

TYPED_TEST(ResolvedOf, WhatIsNotGivenFollowsByItsRule) {
  using T = TypeParam;
  DriveSetup<T> setup;
  setup.basis.u_dc = T(400);
  setup.basis.flux_reference = T(0.7);
  setup.basis.inverter.dead_time_ns = 1500;
  const DriveBasis<T>& basis = setup.basis;
  const DriveLimits<T> limits = drive_limits(basis.machine, T(0.7), T(400));
  const CurrentSensorLimits<T> sensors =
      current_sensor_limits(basis.machine, limits.over_current, T(400), T(25e-6));
  const ResolvedDrive<T> r = resolved(setup);
  ASSERT_EQ(r.validate(), nullptr);
  const auto expect = [](T found, T expected, const char* what) {
    EXPECT_NEAR(double(found), double(expected), 1e-6 * double(expected)) << what;
  };
  const ProtectionLimits<T>& p = r.drive.protection;
  expect(r.drive.command.torque_limit, limits.torque, "torque_limit");
  expect(r.drive.motor.capability.torque, limits.torque, "torque");
  expect(r.drive.motor.capability.current_limit, T(0.8) * limits.over_current, "current_limit");
  expect(r.control.current_limit, T(0.8) * limits.over_current, "current_limit of the controller");
  expect(p.over_current, limits.over_current, "over_current");
  expect(p.dc_over_voltage, limits.dc_over_voltage, "dc_over_voltage");
  expect(p.over_speed, limits.over_speed, "over_speed");
  expect(p.dc_under_voltage, limits.dc_under_voltage, "dc_under_voltage");
  expect(p.current_range, T(10) * limits.over_current, "current_range");
  expect(p.voltage_range, T(10) * limits.dc_over_voltage, "voltage_range");
  expect(p.speed_range, T(10) * limits.over_speed, "speed_range");
  expect(p.current_sum, sensors.sum, "current_sum");
  expect(p.current_offset, limits.current_offset, "current_offset");
  expect(p.current_jump, sensors.jump, "current_jump");
  expect(p.current_noise, sensors.noise, "current_noise");
  expect(p.zero_current, sensors.zero_current, "zero_current");
  expect(p.current_step, sensors.step, "current_step");
  expect(p.speed_jump, limits.speed_jump, "speed_jump");
  expect(p.speed_error, limits.speed_error, "speed_error");
  expect(p.flux_lost_torque, T(0.05) * limits.torque, "flux_lost_torque");
  const TorqueMonitorLimits<T>& monitor = r.drive.torque_monitor;
  expect(monitor.limit, limits.torque_deviation, "limit");
  expect(monitor.wrong_sign, T(0.5) * limits.torque_deviation, "wrong_sign");
  expect(monitor.current_offset, T(4) / T(3) * limits.current_offset, "current_offset of the monitor");
  const T error = basis.inverter.likely_voltage_error(25'000, T(400));
  ASSERT_GT(error, T(0));
  expect(r.control.inverter.voltage_error, error, "voltage_error");
  expect(p.inverter.voltage_error, error, "voltage_error of the protections");
  expect(monitor.inverter.voltage_error, error, "voltage_error of the monitor");
  EXPECT_EQ(r.drive.magnetise_timeout_ns, 1'000'000'000);
  setup.basis.machine.r_r = T(0.25) * basis.machine.r_r;
  EXPECT_NEAR(double(resolved(setup).drive.magnetise_timeout_ns), 5e9 * double(basis.machine.tau_r()), 1e6);
}

// Of a value that stands in the place of another one, what follows from it.
TYPED_TEST(ResolvedOf, WhatIsGivenStandsInThePlaceOfWhatFollows) {
  using T = TypeParam;
  DriveSetup<T> setup;
  setup.command.torque_limit = T(90);
  setup.protection = {.over_current = T(101),
                      .dc_over_voltage = T(720),
                      .over_speed = T(400),
                      .current_offset = T(0.6),
                      .speed_error_ns = 5'000'000,
                      .flux_lost_share = T(0.4),
                      .flux_lost_ns = 150'000'000,
                      .winding_warning = T(120),
                      .winding_trip = T(150)};
  setup.torque_monitor.limit = T(12);
  setup.torque_monitor.machine = setup.basis.machine;
  setup.torque_monitor.machine->r_s = T(0.5);
  setup.optimal_flux.iron_loss_resistance = T(300);
  const ResolvedDrive<T> r = resolved(setup);
  const ProtectionLimits<T>& p = r.drive.protection;
  EXPECT_FLOAT_EQ(float(r.drive.motor.capability.torque), 90.0F);
  EXPECT_FLOAT_EQ(float(r.drive.motor.capability.current_limit), 80.8F);
  EXPECT_FLOAT_EQ(float(p.current_range), 1010.0F);
  EXPECT_FLOAT_EQ(float(p.voltage_range), 7200.0F);
  EXPECT_FLOAT_EQ(float(p.speed_range), 4000.0F);
  EXPECT_FLOAT_EQ(float(p.current_sum), 3.03F);
  EXPECT_FLOAT_EQ(float(p.flux_lost_torque), 4.5F);
  EXPECT_EQ(p.speed_error_ns, 5'000'000);
  EXPECT_EQ(p.flux_lost_ns, 150'000'000);
  EXPECT_EQ(p.flux_lost_share, T(0.4));
  EXPECT_EQ(p.winding_warning, T(120));
  EXPECT_EQ(p.winding_trip, T(150));
  EXPECT_FLOAT_EQ(float(r.drive.torque_monitor.wrong_sign), 6.0F);
  EXPECT_FLOAT_EQ(float(r.drive.torque_monitor.current_offset), 0.8F);
  EXPECT_EQ(r.drive.torque_monitor.machine.r_s, T(0.5));
  EXPECT_EQ(p.machine.r_s, setup.basis.machine.r_s);
  EXPECT_EQ(r.control.iron_loss_resistance, T(300));
  EXPECT_EQ(r.drive.torque_monitor.iron_loss_resistance, T(300));
  EXPECT_EQ(default_parameters<FieldOrientedController<T>>(r.control).iron_loss_resistance, T(300));
}

}  // namespace
}  // namespace sextant
