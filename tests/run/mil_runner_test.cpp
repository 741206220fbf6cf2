#include "sextant/run/mil_runner.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "run/drive_rig.hpp"
#include "sextant/recording/trace_recorder.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;

/// A run and what is left of its parts.
class MilRun {
 public:
  explicit MilRun(const RigParameters& p)
      : stage_{p.stage, p.load}, controller_{p.controller}, drive_{p.drive, controller_} {}

  MilResult operator()(const Scenario& scenario, TraceRecorder* trace = nullptr,
                       const MilRunner::Progress& progress = {}) {
    return MilRunner{drive_, stage_.io(), period_ns, &controller_}.run(scenario, trace, progress);
  }
  const MeteredPlant& plant() { return stage_.io().plant(); }

 private:
  MeteredPowerStage stage_;
  DirectTorqueController<double> controller_;
  Drive<double> drive_;
};

/// Keeps a short circuit, and never has flux.
class WithoutFlux final : public Controller<double> {
 public:
  [[nodiscard]] GatePattern step(const Measurement<double>& /*measurement*/,
                                 ControlReference<double> /*reference*/) noexcept override {
    return GatePattern{switch_states[0], period_ns};
  }
  void reset() noexcept override {}
};

/// One leg is high for half a microsecond of each period.
class WithShortPulses final : public Controller<double> {
 public:
  [[nodiscard]] GatePattern step(const Measurement<double>& /*measurement*/,
                                 ControlReference<double> reference) noexcept override {
    if (reference.mode == ControlMode::off) return GatePattern{gates_off, period_ns};
    GatePattern pattern{switch_states[0], 10'000};
    pattern.append({switch_states[1], 500});
    pattern.append({switch_states[0], period_ns - 10'500});
    return pattern;
  }
  void reset() noexcept override {}
};

Scenario constant_torque(double torque, std::int64_t duration_ns) {
  Scenario scenario;
  scenario.name = "test";
  scenario.duration_ns = duration_ns;
  scenario.torque_reference.value = torque;
  scenario.metrics.step_ns = 0;
  return scenario;
}

TEST(MilRunner, MetricsOfAStepAreThoseOfTheDrive) {
  Scenario scenario = constant_torque(15.0, 400'000'000);
  scenario.metrics.from_ns = 200'000'000;
  MilRun run{RigParameters::at_speed(50.0)};
  const MilResult result = run(scenario);
  EXPECT_TRUE(result.plant_healthy);
  EXPECT_FALSE(result.faults.any());
  EXPECT_EQ(result.final_state, DriveState::torque);
  const MetricList& m = result.metrics;
  EXPECT_NEAR(m[Metric::torque_bias], 0.0, 0.1);
  EXPECT_LT(m[Metric::torque_deviation], 0.5);
  EXPECT_EQ(m[Metric::torque_silent], 0);
  EXPECT_LT(m[Metric::response_time], 5.0);
  EXPECT_GT(m[Metric::torque_ripple_pp], 3.0) << "25 µs of an active vector are several N·m";
  EXPECT_LT(m[Metric::torque_ripple_pp], 14.0);
  EXPECT_NEAR(m[Metric::flux_mean], 1.1, 0.03);
  EXPECT_GT(m[Metric::switching_frequency], 500.0);
  EXPECT_LT(m[Metric::switching_frequency], 20'000.0) << "half the sampling frequency bounds every leg";
  EXPECT_NEAR(m[Metric::simulated], 0.4, 1e-12);
  EXPECT_GT(m[Metric::wall], 0.0);
  EXPECT_NEAR(m[Metric::realtime_factor] * m[Metric::wall], 0.4, 1e-9);
}

TEST(MilRunner, AWrongStatorResistanceMakesTheTorqueDepartFromTheCommandInSilence) {
  Scenario scenario = constant_torque(15.0, 400'000'000);
  scenario.metrics.from_ns = 200'000'000;
  RigParameters p = RigParameters::at_speed(50.0);
  p.stage.plant.machine.r_s *= 0.5;
  p.drive.protection.over_current = 1e6;
  p.drive.protection.flux_lost_share = 0;
  p.drive.protection.speed_error = 1e6;
  p.drive.torque_monitor.enabled = false;
  const MetricList m = MilRun{p}(scenario).metrics;
  EXPECT_GT(m[Metric::torque_deviation], 20);
  EXPECT_NEAR(m[Metric::torque_silent], 200, 0.026) << "the whole window";
  EXPECT_EQ(m[Metric::torque_motoring], p.drive.motor.capability.torque);
}

TEST(MilRunner, CountsShortPulsesWhereThereIsAMinimumPulse) {
  const auto counted = [](std::int32_t minimum_ns) {
    RigParameters p = RigParameters::at_speed(0.0);
    p.stage.io.minimum_pulse.duration_ns = minimum_ns;
    MeteredPowerStage stage{p.stage, p.load};
    WithShortPulses controller;
    Drive<double> drive{p.drive, controller};
    return MilRunner{drive, stage.io(), period_ns}
        .run(constant_torque(0.0, 50'000'000), nullptr, {})
        .metrics[Metric::short_pulses];
  };
  EXPECT_NEAR(counted(1'000), 50'000'000 / period_ns, 2) << "one in each period with gates on";
  EXPECT_EQ(counted(500), 0);
  EXPECT_TRUE(std::isnan(counted(0)));
}

TEST(MilRunner, ADriveThatDoesNotGetReadyMakesNoTorque) {
  RigParameters p = RigParameters::at_speed(20.0);
  p.drive.magnetise_first = true;
  MeteredPowerStage stage{p.stage, p.load};
  WithoutFlux controller;
  Drive<double> drive{p.drive, controller};
  const MilResult result =
      MilRunner{drive, stage.io(), period_ns}.run(constant_torque(15.0, 200'000'000), nullptr, {});
  EXPECT_FALSE(result.faults.any());
  ASSERT_TRUE(result.missing_torque);
  EXPECT_EQ(result.missing_torque->asked, 15);
  EXPECT_LT(std::abs(result.missing_torque->made), 1);
  EXPECT_EQ(result.missing_torque->state, DriveState::magnetising);
  EXPECT_FALSE(MilRun{RigParameters::at_speed(20.0)}(constant_torque(15.0, 200'000'000)).missing_torque);
}

TEST(MilRunner, ARunIsRepeatedExactly) {
  const Scenario scenario = constant_torque(15.0, 50'000'000);
  MilRun first{RigParameters{}};
  MilRun second{RigParameters{}};
  first(scenario);
  second(scenario);
  EXPECT_EQ(first.plant().state(), second.plant().state());
}

TEST(MilRunner, ATripIsReportedWithItsFirstFaultAndItsInstant) {
  RigParameters p;
  p.drive.protection.over_current = 50.0;
  MilRun run{p};
  const MilResult result = run(constant_torque(15.0, 20'000'000));
  EXPECT_EQ(result.final_state, DriveState::fault);
  EXPECT_TRUE(result.faults.test(Fault::over_current));
  EXPECT_EQ(result.first_fault, Fault::over_current);
  EXPECT_GT(result.fault_ns, 0);
  EXPECT_LT(result.fault_ns, 5'000'000);
  EXPECT_GT(result.metrics[Metric::peak_current], 50.0);
  EXPECT_LT(result.metrics[Metric::peak_current], 60.0);
  EXPECT_LT(magnitude(run.plant().i_s()), 1e-6) << "the currents die with the gates off";
  EXPECT_TRUE(result.plant_healthy);
}

TEST(MilRunner, AFailedIntegrationEndsTheRunAndLatches) {
  RigParameters p;
  p.stage.integrator = IntegratorKind::cvode;
  p.stage.cvode.max_steps = 1;
  MilRun run{p};
  const MilResult result = run(constant_torque(15.0, 20'000'000));
  EXPECT_FALSE(result.plant_healthy);
  EXPECT_EQ(result.final_state, DriveState::fault);
  EXPECT_EQ(result.first_fault, Fault::measurement_invalid);
  EXPECT_LT(result.metrics[Metric::simulated], 0.02);
}

TEST(MilRunner, TheCallerCanStopIt) {
  MilRun run{RigParameters{}};
  double last = 0.0;
  const MilResult result = run(constant_torque(15.0, 3'600'000'000'000), nullptr, [&last](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    return false;
  });
  EXPECT_NEAR(result.metrics[Metric::simulated], last * 3600.0, 1e-6) << "as far as it came";
  EXPECT_LT(last, 0.5);
}

TEST(MilRunner, EveryPeriodIsTraced) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("sextant_mil_runner_" + std::to_string(::getpid()) + ".h5");
  Scenario scenario = constant_torque(15.0, 10'000'000);
  scenario.trace.interval_us = 25;
  {
    TraceRecorder trace{file, scenario.trace, {scenario.name, period_ns}};
    MilRun run{RigParameters{}};
    run(scenario, &trace);
    trace.close();
    EXPECT_EQ(trace.error(), "");
  }
  EXPECT_GT(std::filesystem::file_size(file), 401U * 8U);
  std::filesystem::remove(file);
}

TEST(MilRunner, RefusesAWindowThatIsNone) {
  Scenario scenario = constant_torque(15.0, 10'000'000);
  scenario.metrics = {.from_ns = 2, .to_ns = 1};
  MilRun run{RigParameters{}};
  EXPECT_THROW(run(scenario), std::runtime_error);
}

}  // namespace
}  // namespace sextant
