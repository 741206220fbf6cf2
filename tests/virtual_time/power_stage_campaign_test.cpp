// Rows 25, 32 and 33 of the fault list, in virtual time, and the watchdog: late wake-ups and measurements.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "virtual_time/campaign.hpp"
#include "virtual_time/injection.hpp"

namespace sextant::test {
namespace {

constexpr std::uint64_t seeds = 40;
constexpr std::int64_t T = VirtualRig::period_ns;

TEST(PowerStageCampaign, Row25OneOverrunMissesWholePeriodsAndKeepsThePhase) {
  for_seeds(seeds, [](CampaignCase& c) {
    const std::int64_t wake = c.wake_ns();
    const std::int64_t late_ns = wake * c.between(1, 20) + c.between(0, wake - 1);
    c.rig.late_wakes = {{c.at_ns, late_ns}};
    VirtualRig rig{c.rig};
    ASSERT_TRUE(rig.start());
    std::int64_t before_ns = rig.now().t_ns;
    std::int64_t missing = 0;
    rig.on_period = [&](const Telemetry<double>& t) {
      EXPECT_EQ(t.t_ns % T, 0);
      missing += (t.t_ns - before_ns) / T - 1;
      before_ns = t.t_ns;
    };
    rig.run_until(400 * ms);
    const std::int64_t skipped = late_ns / wake * c.rig.wake_every_periods;
    EXPECT_EQ(rig.ecu.wakes().overruns, 1U);
    EXPECT_EQ(std::int64_t(rig.ecu.wakes().periods_missed), skipped);
    EXPECT_EQ(missing, skipped);
    EXPECT_EQ(rig.now().state, DriveState::torque);
    EXPECT_FALSE(rig.now().latched.any());
  });
}

TEST(PowerStageCampaign, AWakeUpThatIsLateByLessThanItsPeriodMissesNoPeriod) {
  for_seeds(seeds / 2, [](CampaignCase& c) {
    c.rig.late_wakes = {{c.at_ns, c.between(1, c.wake_ns() - 1)}};
    VirtualRig rig{c.rig};
    ASSERT_TRUE(rig.start());
    const HoldsSetpoint watch{rig};
    rig.run_until(400 * ms);
    EXPECT_TRUE(watch.held());
    EXPECT_EQ(rig.ecu.wakes().overruns, 0U);
    // With each period a wake-up, those up to and including the one at 400 ms have run.
    const std::int64_t wakes = 400 * ms / c.wake_ns();
    EXPECT_EQ(std::int64_t(rig.recorder.periods()), wakes * c.rig.wake_every_periods);
  });
}

TEST(PowerStageCampaign, AStallBeyondTheWatchdogsTimeTripsInTheFirstPeriodAfterIt) {
  for_seeds(seeds / 2, [](CampaignCase& c) {
    c.rig.late_wakes = {{c.at_ns, c.between(101, 180) * ms}};
    VirtualRig rig{c.rig};
    ASSERT_TRUE(rig.start());
    std::optional<std::int64_t> after_ns;
    std::int64_t before_ns = rig.now().t_ns;
    rig.on_period = [&](const Telemetry<double>& t) {
      if (!after_ns && t.t_ns - before_ns > 50 * ms) after_ns = t.t_ns;
      before_ns = t.t_ns;
    };
    rig.run_until(600 * ms);
    ASSERT_TRUE(after_ns);
    EXPECT_EQ(rig.first_fault_ns, *after_ns);
    EXPECT_EQ(rig.now().first_fault, Fault::watchdog);
  });
}

/// A measurement that is wrong for one period trips in that period, turns the gates off and stays so.
void expect_trip_at_once(CampaignCase& c, MeasurementEvent event, Fault fault) {
  VirtualRig rig{c.rig};
  ASSERT_TRUE(rig.start());
  event.begin_ns = on_grid(c.at_ns);
  event.end_ns = event.begin_ns + T;
  rig.io.add(event);
  rig.forget();
  bool off = true;
  rig.on_period = [&](const Telemetry<double>& t) {
    off = off && (t.t_ns < event.begin_ns || t.pattern.last_state() == gates_off);
  };
  rig.run_for(100 * ms);
  EXPECT_EQ(rig.first_fault_ns, event.begin_ns);
  EXPECT_EQ(rig.now().first_fault, fault);
  EXPECT_EQ(rig.now().state, DriveState::fault);
  EXPECT_TRUE(off);
}

TEST(PowerStageCampaign, Row32ANumberThatIsNoneTripsInItsPeriod) {
  constexpr std::array values{std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};
  for_seeds(seeds, [&](CampaignCase& c) {
    MeasurementEvent event;
    event.signal = static_cast<MeasuredSignal>(c.between(0, 4));
    event.offset = values[std::size_t(c.between(0, 2))];
    expect_trip_at_once(c, event, Fault::measurement_invalid);
  });
}

TEST(PowerStageCampaign, Row33OverCurrentTripsInItsPeriod) {
  for_seeds(seeds, [](CampaignCase& c) {
    const double limit = c.rig.config.drive.protection.over_current;
    const double sign = c.between(0, 1) == 0 ? -1.0 : 1.0;
    expect_trip_at_once(c,
                        {.signal = static_cast<MeasuredSignal>(c.between(0, 2)),
                         .offset = sign * (limit + double(c.between(1, 1000)) * 0.1)},
                        Fault::over_current);
  });
}

TEST(PowerStageCampaign, Row33OverVoltageTripsInItsPeriod) {
  for_seeds(seeds, [](CampaignCase& c) {
    const double limit = c.rig.config.drive.protection.dc_over_voltage;
    expect_trip_at_once(c,
                        {.signal = MeasuredSignal::u_dc, .offset = limit + double(c.between(1, 1000)) * 0.1},
                        Fault::dc_over_voltage);
  });
}

TEST(PowerStageCampaign, ATripIsLeftByResetDisableEnableAlone) {
  for_seeds(seeds / 2, [](CampaignCase& c) {
    c.rig.vehicle.clear_faults = c.between(0, 1) == 1;
    VirtualRig rig{c.rig};
    ASSERT_TRUE(rig.start());
    const std::int64_t at = on_grid(c.at_ns);
    rig.io.add({.signal = MeasuredSignal::u_dc, .begin_ns = at, .end_ns = at + T, .offset = 1000.0});
    rig.run_for(600 * ms);
    EXPECT_EQ(rig.first_fault_ns, at);
    // A vehicle that only goes on enabling gets nothing.
    EXPECT_EQ(rig.now().state, c.rig.vehicle.clear_faults ? DriveState::torque : DriveState::fault);
  });
}

}  // namespace
}  // namespace sextant::test
