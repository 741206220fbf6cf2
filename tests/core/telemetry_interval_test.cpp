#include "sextant/core/telemetry_interval.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include "support/source_directory.hpp"

namespace sextant {
namespace {

template <class T>
class TelemetryIntervalOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TelemetryIntervalOf, Scalars);

TYPED_TEST(TelemetryIntervalOf, MeanMinimumAndMaximumRunOverItsPeriods) {
  using T = TypeParam;
  TelemetryInterval<T> interval;
  for (const T x : {T(3), T(-1), T(4), T(2)}) {
    Telemetry<T> t;
    t.torque = x;
    t.psi_s_magnitude = T(10) + x;
    t.i_abc = inverse_clarke(polar(T(20) + x, x));
    interval.add(t);
  }
  const auto r = interval.record();
  const T tolerance = T(16) * std::numeric_limits<T>::epsilon() * T(24);
  EXPECT_EQ(r.periods, 4U);
  EXPECT_NEAR(r.torque_mean_nm, T(2), tolerance);
  EXPECT_EQ(r.torque_min_nm, T(-1));
  EXPECT_EQ(r.torque_max_nm, T(4));
  EXPECT_NEAR(r.flux_mean_wb, T(12), tolerance);
  EXPECT_EQ(r.flux_min_wb, T(9));
  EXPECT_EQ(r.flux_max_wb, T(14));
  EXPECT_NEAR(r.current_mean_a, T(22), tolerance);
  EXPECT_NEAR(r.current_min_a, T(19), tolerance);
  EXPECT_NEAR(r.current_max_a, T(24), tolerance);
}

TYPED_TEST(TelemetryIntervalOf, OnePeriodIsItsOwnMeanMinimumAndMaximum) {
  using T = TypeParam;
  TelemetryInterval<T> interval;
  Telemetry<T> t;
  t.torque = T(-7.5);
  t.psi_s_magnitude = T(1.1);
  interval.add(t);
  const auto r = interval.record();
  EXPECT_EQ(r.torque_mean_nm, T(-7.5));
  EXPECT_EQ(r.torque_min_nm, T(-7.5));
  EXPECT_EQ(r.torque_max_nm, T(-7.5));
  EXPECT_EQ(r.flux_mean_wb, T(1.1));
}

TEST(TelemetryInterval, OtherValuesAreThoseOfTheLastPeriod) {
  TelemetryInterval<> interval;
  interval.add(Telemetry<>{.t_ns = 1, .omega_m = 98, .torque_requested = 99, .sector = 1});
  interval.add(Telemetry<>{.t_ns = 25'001,
                           .i_abc = {1, 2, -3},
                           .omega_m = -40,
                           .psi_s = polar(1.1, 2.5),
                           .torque_requested = 20,
                           .torque_reference = 15,
                           .command_received_ns = 777,
                           .command_counter = 9,
                           .sector = 4,
                           .state = DriveState::derated,
                           .derating_cause = DeratingCause::voltage_limit});
  const auto r = interval.record();
  EXPECT_EQ(r.t_ns, 25'001);
  EXPECT_EQ(r.torque_requested_nm, 20);
  EXPECT_EQ(r.torque_reference_nm, 15);
  EXPECT_EQ(r.i_a_a, 1);
  EXPECT_EQ(r.i_b_a, 2);
  EXPECT_EQ(r.i_c_a, -3);
  EXPECT_NEAR(r.flux_angle_rad, 2.5, 1e-12);
  EXPECT_EQ(r.speed_rad_s, -40);
  EXPECT_EQ(r.state, DriveState::derated);
  EXPECT_EQ(r.sector, 4);
  EXPECT_EQ(r.command_counter, 9);
  EXPECT_EQ(r.command_received_ns, 777);
  EXPECT_EQ(r.derating_cause, 2);
}

TEST(TelemetryInterval, PowerIsTheMeanOfTheProductNotTheProductOfTheMeans) {
  TelemetryInterval<> interval;
  interval.add(Telemetry<>{.u_dc = 500, .i_dc = 10});
  interval.add(Telemetry<>{.u_dc = 600, .i_dc = -20});
  const auto r = interval.record();
  EXPECT_DOUBLE_EQ(r.u_dc_v, 550);
  EXPECT_DOUBLE_EQ(r.i_dc_a, -5);
  EXPECT_DOUBLE_EQ(r.power_w, (5000.0 - 12000.0) / 2);
}

TEST(TelemetryInterval, IsEmptyAtFirstAndAfterReset) {
  TelemetryInterval<> interval;
  EXPECT_EQ(interval.count(), 0U);
  EXPECT_EQ(interval.record().periods, 0U);
  interval.add(Telemetry<>{.t_ns = 5, .torque = 100});
  EXPECT_EQ(interval.count(), 1U);
  interval.reset();
  EXPECT_EQ(interval.count(), 0U);
  EXPECT_EQ(interval.record().t_ns, 0);
  interval.add(Telemetry<>{.torque = 2});
  EXPECT_EQ(interval.record().torque_max_nm, 2);
  EXPECT_EQ(interval.record().torque_mean_nm, 2);
}

TEST(TelemetryInterval, NanShowsInTheMeanAndLeavesTheExtremesToTheNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::array values{nan, 1.0, 3.0};
  for (int turn = 0; turn < 3; ++turn) {
    TelemetryInterval<> interval;
    for (const double x : values) interval.add(Telemetry<>{.torque = x});
    EXPECT_TRUE(std::isnan(interval.record().torque_mean_nm));
    EXPECT_EQ(interval.record().torque_min_nm, 1);
    EXPECT_EQ(interval.record().torque_max_nm, 3);
    std::rotate(values.begin(), values.begin() + 1, values.end());
  }
  TelemetryInterval<> all_nan;
  all_nan.add(Telemetry<>{.torque = nan});
  EXPECT_TRUE(std::isnan(all_nan.record().torque_min_nm));
  EXPECT_TRUE(std::isnan(all_nan.record().torque_max_nm));
}

TEST(TelemetryInterval, MeanLiesBetweenMinimumAndMaximumForRandomTorque) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random{seed};
    std::normal_distribution<float> torque{15.0F, 3.0F};
    TelemetryInterval<float> interval;
    double sum = 0;
    constexpr int n = 40'000;
    for (int k = 0; k < n; ++k) {
      Telemetry<float> t;
      t.torque = torque(random);
      sum += double(t.torque);
      interval.add(t);
    }
    const auto r = interval.record();
    EXPECT_LT(r.torque_min_nm, r.torque_mean_nm);
    EXPECT_LT(r.torque_mean_nm, r.torque_max_nm);
    EXPECT_NEAR(double(r.torque_mean_nm), sum / n, 1e-3);
  }
}

TEST(TelemetryInterval, FillsEveryMemberOfTheRecord) {
  TelemetryInterval<> interval;
  interval.add(Telemetry<>{.t_ns = 1,
                           .i_abc = {1, 2, -3},
                           .u_dc = 530,
                           .omega_m = 40,
                           .i_dc = 7,
                           .psi_s = polar(1.1, 2.5),
                           .psi_s_magnitude = 1.1,
                           .torque = 15,
                           .torque_requested = 20,
                           .torque_reference = 16,
                           .command_received_ns = 777,
                           .command_counter = 9,
                           .sector = 4,
                           .state = DriveState::torque});
  const auto r = interval.record();
#define SEXTANT_EXPECT(member, unit, text) EXPECT_NE(r.member, decltype(r.member){}) << #member;
  SEXTANT_TELEMETRY_MEMBERS(SEXTANT_EXPECT)
#undef SEXTANT_EXPECT
}

static_assert(std::is_trivially_copyable_v<TelemetryIntervalRecord<>>);

}  // namespace
}  // namespace sextant
