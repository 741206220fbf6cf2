// Random steps of the torque command through noisy sensors, against the plant's torque.

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"

namespace sextant {
namespace {

/// Converters of 12 bits with noise, offsets and gains of opposite sign in two phases, an encoder.
SensorParameters noisy_sensors(unsigned seed) {
  const double sign = seed % 2 == 0 ? 1.0 : -1.0;
  SensorParameters p;
  p.seed = seed;
  p.current = {.noise = 0.2, .range = 300.0, .bits = 12};
  p.phases[0] = {.gain_error = 0.02 * sign, .offset = 0.5};
  p.phases[1] = {.gain_error = -0.02 * sign, .offset = -0.5};
  p.voltage = {.noise = 0.5, .range = 1000.0, .bits = 12};
  p.encoder.lines = 1024;
  return p;
}

/// The drive of configs/ecu.toml; its speed goes up and down between two values, once a second.
RigParameters rig_between(double from, double to, unsigned seed) {
  RigParameters p = RigParameters::at_speed(from, IntegratorKind::exact);
  p.load.imposed_speed = ProfileParameters{.shape = ProfileShape::sine,
                                           .value = 0.5 * (from + to),
                                           .amplitude = 0.5 * (from - to),
                                           .frequency_hz = 1.0,
                                           .phase_deg = 90.0};
  p.stage.io.sensors = noisy_sensors(seed);
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  p.controller.magnetiser = {.current_limit = 40.0, .hand_over_current = 30.0};
  p.drive.magnetise_first = true;
  p.drive.protection.over_current = 250.0;
  return p;
}

TEST(RandomSteps, ThroughNoisySensorsTheTorqueStaysUnderControl) {
  for (unsigned seed = 1; seed <= 16; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random{seed};
    std::uniform_real_distribution<double> torque{-130.0, 130.0};
    std::uniform_real_distribution<double> speed{-30.0, 30.0};
    std::uniform_real_distribution<double> hold{0.1, 0.5};
    const double from = speed(random);
    DriveRig rig{rig_between(from, speed(random), seed)};
    rig.start();
    rig.run(0.15);
    for (int k = 0; k < 12; ++k) {
      rig.torque = torque(random);
      rig.run(hold(random));
      const double error = rig.watch(0.02).mean_torque - rig.torque;
      EXPECT_LT(std::abs(error), 15.0) << rig.torque << " N·m at " << rig.plant().omega_m() << " rad/s";
    }
    EXPECT_EQ(rig.drive().state(), DriveState::torque);
    EXPECT_FALSE(rig.telemetry.latched.any());
  }
}

}  // namespace
}  // namespace sextant
