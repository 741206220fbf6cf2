#include "sextant/event_exact/event_exact_runner.hpp"

#include <cmath>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "event_exact/event_exact_setup.hpp"

namespace sextant {
namespace {

double metric(const MilResult& result, Metric m) {
  return result.metrics[m];
}

TEST(EventExactRunner, TheRippleIsTheBand) {
  for (const double torque : {15.0, 60.0, -15.0}) {
    for (const double speed : {10.0, 30.0}) {
      const MilResult r = EventExactSetup::at(torque, std::copysign(speed, torque)).run();
      EXPECT_GE(metric(r, Metric::torque_ripple_pp), 0.90) << torque << " N·m at " << speed;
      EXPECT_LE(metric(r, Metric::torque_ripple_pp), 0.95) << torque << " N·m at " << speed;
      EXPECT_NEAR(std::abs(metric(r, Metric::torque_bias)), 0.459, 0.01) << torque << " N·m at " << speed;
    }
  }
}

TEST(EventExactRunner, HalfTheBandIsHalfTheRipple) {
  const MilResult whole = EventExactSetup::at(15, 20).with_bands(1.0).run();
  const MilResult half = EventExactSetup::at(15, 20).with_bands(0.5).run();
  EXPECT_NEAR(metric(half, Metric::torque_ripple_pp) / metric(whole, Metric::torque_ripple_pp), 0.5, 0.02);
  EXPECT_NEAR(metric(half, Metric::torque_pulse_frequency) / metric(whole, Metric::torque_pulse_frequency), 2,
              0.1);
}

TEST(EventExactRunner, FluxStaysWithinItsBandOnceItStands) {
  EventExactSetup s = EventExactSetup::at(15, 30);
  s.scenario.metrics.from_ns = 120'000'000;
  const MilResult r = s.run();
  EXPECT_GT(metric(r, Metric::flux_min), 1.1 * 0.985);
  EXPECT_LE(metric(r, Metric::flux_max), 1.1 + 0.010001);
}

TEST(EventExactRunner, ADeadMachineAnswersWithinMilliseconds) {
  const MilResult r = EventExactSetup::at(15, 0).run();
  EXPECT_NEAR(metric(r, Metric::response_time), 2.88, 0.1) << "measured in trials of the paper's machine";
}

TEST(EventExactRunner, AMagnetisedMachineAnswersAtTheSpeedOfItsLeakage) {
  EventExactSetup s = EventExactSetup::at(15, 0);
  s.parameters.event_exact.initial_flux = 1.1;
  // Slope of the torque under a vector a quarter turn ahead: 3/2 p k_r/σL_s ψ_r 2/3 u_dc.
  const auto& m = s.parameters.plant.machine;
  const double psi_r = m.l_m / m.l_s() * 1.1;
  const double slope = 1.5 * m.pole_pairs * m.k_r() / m.sigma_l_s() * psi_r * 2 / 3 * s.parameters.u_dc;
  const double fastest_ms = 0.95 * 15 / slope * 1e3;
  const double response = metric(s.run(), Metric::response_time);
  EXPECT_GT(response, 0.9 * fastest_ms);
  EXPECT_LT(response, 2.5 * fastest_ms);
}

TEST(EventExactRunner, CvodeAndTheFixedStepAgreeOnTheMetrics) {
  const MilResult fixed = EventExactSetup::at(15, 30, 0.5).run();
  const MilResult cvode = EventExactSetup::at(15, 30, 0.5).with_cvode(1e-8).run();
  for (const Metric m : {Metric::torque_ripple_rms, Metric::torque_bias, Metric::flux_mean,
                         Metric::switching_frequency, Metric::torque_pulse_frequency}) {
    EXPECT_NEAR(metric(cvode, m) / metric(fixed, m), 1, 0.005) << info(m).name;
  }
}

TEST(EventExactRunner, EnergyBalances) {
  EventExactSetup s = EventExactSetup::at(15, 30, 0.5);
  s.parameters.event_exact.initial_flux = 1.1;
  s.scenario.metrics.from_ns = 0;
  const MilResult r = s.run();
  const double link = metric(r, Metric::energy_from_link) - metric(r, Metric::energy_to_link);
  const double spent = metric(r, Metric::energy_shaft) + metric(r, Metric::energy_copper);
  // The field holds about as much at the end as at the beginning: 3/4 ψ²/L_s and the leakage of the load.
  const auto& m = s.parameters.plant.machine;
  const double field = 0.75 * 1.1 * 1.1 / m.l_s();
  EXPECT_NEAR(link, spent, 0.2 * field);
  EXPECT_GT(link, 20 * field) << "or the balance would say nothing";
}

TEST(EventExactRunner, TheMemorylessReadingSlidesAndTheDwellEndsIt) {
  EventExactSetup s = EventExactSetup::at(15, 30, 0.05);
  s.parameters.control.torque_comparator.reading = ComparatorReading::memoryless;
  const MilResult r = s.run();
  EXPECT_TRUE(r.plant_healthy);
  EXPECT_GT(metric(r, Metric::dwell_limited), 1000);
  // A state lasts 100 ns at least and a pulse takes two of them.
  EXPECT_LE(metric(r, Metric::torque_pulse_frequency), 0.5 / 100e-9);
}

TEST(EventExactRunner, WithoutADwellAnEndlessSequenceOfEventsIsReported) {
  EventExactSetup s = EventExactSetup::at(15, 30, 0.05);
  s.parameters.control.torque_comparator.reading = ComparatorReading::memoryless;
  s.parameters.event_exact.minimum_dwell_ns = 0;
  s.parameters.event_exact.max_events = 200'000;
  const MilResult r = s.run();
  EXPECT_FALSE(r.plant_healthy);
  EXPECT_FALSE(r.events_ended);
  EXPECT_LT(metric(r, Metric::simulated), 0.05);
}

TEST(EventExactRunner, SectorsThatStartOnV1CannotStartBackwards) {
  EventExactSetup s = EventExactSetup::at(-15, 0, 0.2);
  s.parameters.control.sector.sector_start_deg = 0;
  EXPECT_TRUE(std::isnan(metric(s.run(), Metric::response_time)));
  EXPECT_FALSE(std::isnan(metric(EventExactSetup::at(-15, 0, 0.2).run(), Metric::response_time)));
}

TEST(EventExactRunner, AnOverCurrentEndsTheRunAndIsNamed) {
  EventExactSetup s = EventExactSetup::at(15, 0);
  s.parameters.protection.over_current = 50;
  const MilResult r = s.run();
  EXPECT_EQ(r.first_fault, Fault::over_current);
  EXPECT_TRUE(r.faults.test(Fault::over_current));
  EXPECT_LT(metric(r, Metric::simulated), 0.01);
  EXPECT_NEAR(metric(r, Metric::peak_current), 50, 2);
}

// The rows of a trace end pieces of the integration.
TEST(EventExactRunner, ATraceDoesNotMoveATrip) {
  EventExactSetup s = EventExactSetup::at(15, 0);
  for (const double over_current : {30.0, 50.0, 62.0}) {
    s.parameters.protection.over_current = over_current;
    const MilResult without = s.run();
    ASSERT_EQ(without.first_fault, Fault::over_current);
    for (const double interval_us : {10.0, 130.0, 1000.0}) {
      SCOPED_TRACE(testing::Message() << over_current << " A, rows of " << interval_us << " us");
      s.scenario.trace.interval_us = interval_us;
      const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                         ("sextant_event_exact_" + std::to_string(getpid()) + ".h5");
      {
        TraceRecorder trace{file, s.scenario.trace, {}};
        const MilResult with = s.run(&trace);
        EXPECT_EQ(with.fault_ns, without.fault_ns);
        EXPECT_EQ(with.fault_ns % s.parameters.protection.period_ns, 0);
      }
      std::filesystem::remove(file);
    }
  }
}

TEST(EventExactRunner, ARampOfTheReferenceIsAnsweredOnceItPassesTheBand) {
  EventExactSetup s = EventExactSetup::at(0, 20, 0.1);
  constexpr double slope = 50;
  s.scenario.torque_reference = {.shape = ProfileShape::linear, .points = {{0, 0}, {0.1, slope * 0.1}}};
  s.scenario.metrics = {.from_ns = 0, .to_ns = static_cast<std::int64_t>(0.918 / slope * 1e9) - 1000};
  const MilResult r = s.run();
  EXPECT_EQ(metric(r, Metric::torque_pulse_frequency), 0);
  EXPECT_NEAR(metric(r, Metric::torque_error_max), 0.918, 1e-3);
  s.scenario.metrics.to_ns += 2'000'000;
  EXPECT_GT(metric(s.run(), Metric::torque_pulse_frequency), 0);
}

TEST(EventExactRunner, AnImposedSpeedFollowsItsProfile) {
  EventExactSetup s = EventExactSetup::at(0, 0, 0.2);
  s.parameters.event_exact.initial_flux = 1.1;
  s.scenario.load.imposed_speed =
      ProfileParameters{.shape = ProfileShape::linear, .points = {{0, 0}, {0.1, 20}, {0.2, 0}}};
  s.scenario.torque_reference.value = 10;
  s.scenario.metrics.from_ns = 0;
  const MilResult r = s.run();
  // Work of a torque near 10 N·m on a triangle of speed: 10 · 20 · 0.2/2.
  EXPECT_NEAR(metric(r, Metric::energy_shaft), (10 + metric(r, Metric::torque_bias)) * 2, 0.05);
}

TEST(EventExactRunner, AJumpOfTheImposedSpeedActsAtItsInstant) {
  EventExactSetup s = EventExactSetup::at(10, 0, 0.2);
  s.parameters.event_exact.initial_flux = 1.1;
  s.scenario.load.imposed_speed =
      ProfileParameters{.shape = ProfileShape::steps, .points = {{0, 5}, {0.1, 25}}};
  s.scenario.metrics = {.from_ns = 100'000'000};
  // ∫ T dt at a constant speed of 25 rad/s from the jump on. The bias takes the torque along lines between
  // events.
  const MilResult r = s.run();
  EXPECT_NEAR(metric(r, Metric::energy_shaft), (10 + metric(r, Metric::torque_bias)) * 25 * 0.1, 2e-3);
}

TEST(EventExactRunner, AFreeShaftAcceleratesByTheSurplusOfTorque) {
  EventExactSetup s = EventExactSetup::at(15, 0, 0.4);
  s.scenario.load = {.load_torque = {.value = 5}};
  s.scenario.metrics.from_ns = 0;
  const MilResult r = s.run();
  // E = ∫ T ω dt with dω/dt = (T − 5)/J, T taken at its mean.
  const double torque = 15 + metric(r, Metric::torque_bias);
  const double omega = (torque - 5) / s.parameters.plant.machine.inertia * 0.4;
  EXPECT_NEAR(metric(r, Metric::energy_shaft), torque * omega * 0.4 / 2, 0.02 * torque * omega * 0.2);
}

/// 200 machines within plausible ranges, where the vectors hold the torque: the ripple is the band, nothing
/// is Zeno, the energies balance.
TEST(EventExactRunner, HoldsOnRandomMachines) {
  constexpr unsigned first_seed = 3000;
  for (unsigned seed = first_seed; seed < first_seed + 200; ++seed) {
    std::mt19937 random{seed};
    const auto between = [&random](double a, double b) {
      return std::uniform_real_distribution<double>{a, b}(random);
    };
    EventExactSetup s = EventExactSetup::at(0, 0, 0.06);
    auto& m = s.parameters.plant.machine;
    m.r_s = between(0.2, 0.8);
    m.r_r = between(0.3, 1.2);
    m.l_ls = between(1.5e-3, 4e-3);
    m.l_lr = between(1.5e-3, 4e-3);
    m.l_m = between(0.05, 0.15);
    m.pole_pairs = std::uniform_int_distribution<int>{1, 4}(random);
    s.parameters.u_dc = between(400, 700);
    s.parameters.control.machine = m;
    s.parameters.event_exact.initial_flux = 1.1;
    // A tenth of the speed at which the flux alone takes the whole voltage.
    const double speed = 0.1 * s.parameters.u_dc / std::sqrt(3.0) / 1.1 / m.pole_pairs;
    const double torque = between(5, 15) * m.pole_pairs;
    s.scenario.torque_reference.value = torque;
    s.scenario.load.imposed_speed->value = speed;
    s.scenario.metrics.from_ns = 20'000'000;
    const MilResult r = s.run();
    ASSERT_TRUE(r.plant_healthy) << "seed " << seed;
    // What the torque moves while an event waits for the minimum dwell comes on top.
    const double slope = 1.5 * m.pole_pairs * m.k_r() / m.sigma_l_s() * 1.1 * 2 / 3 * s.parameters.u_dc;
    const double dwell = double(s.parameters.event_exact.minimum_dwell_ns) * 1e-9;
    EXPECT_GT(metric(r, Metric::torque_ripple_pp), 0.917) << "seed " << seed;
    EXPECT_LT(metric(r, Metric::torque_ripple_pp), 0.919 + 1.5 * slope * dwell) << "seed " << seed;
    EXPECT_LT(metric(r, Metric::dwell_limited), 0.01 * metric(r, Metric::torque_pulse_frequency) * 0.06)
        << "seed " << seed;
    s.scenario.metrics.from_ns = 0;
    const MilResult whole = s.run();
    const double link = metric(whole, Metric::energy_from_link) - metric(whole, Metric::energy_to_link);
    const double spent = metric(whole, Metric::energy_shaft) + metric(whole, Metric::energy_copper);
    const double field = 0.75 * 1.1 * 1.1 / m.l_s();
    EXPECT_NEAR(link, spent, 0.25 * field + 1e-3 * std::abs(spent)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace sextant
