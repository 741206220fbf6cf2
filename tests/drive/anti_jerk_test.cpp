// The correction against the frequency response of two high-passes, and what the drive makes of it.
#include "sextant/drive/anti_jerk.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "drive/fake_controller.hpp"
#include "sextant/drive/drive.hpp"

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double dt = 25e-6;
constexpr std::int64_t ms = 1'000'000;
constexpr std::int32_t period_ns = 25'000;

TEST(AntiJerk, IsTheFrequencyResponseOfTwoHighPasses) {
  for (const double hz : {0.5, 2.0, 8.0, 60.0}) {
    AntiJerk<double> one{{.gain = 3.0, .corner = 2.0}};
    const double omega = 2 * pi * hz;
    std::complex<double> sum{};
    const auto n = std::llround(1.0 / (hz * dt));
    const std::int64_t begin =
        n * std::llround(std::ceil(3.0 * hz));  // three seconds, some 38 time constants
    for (std::int64_t k = 0; k < begin + n; ++k) {
      const double correction = one.step(100.0 + std::cos(omega * double(k) * dt), dt);
      if (k >= begin) sum += correction * std::polar(2.0 / double(n), -omega * double(k) * dt);
    }
    const std::complex<double> s{0.0, hz / 2.0};  // by the corner
    const std::complex<double> expected = -3.0 * std::pow(s / (1.0 + s), 2);
    EXPECT_LT(std::abs(sum - expected), 0.01 * 3.0 * std::abs(s / (1.0 + s))) << hz;
  }
}

TEST(AntiJerk, TakesNothingFromAConstantAcceleration) {
  AntiJerk<double> one{{.gain = 3.0, .corner = 2.0}};
  EXPECT_EQ(one.step(-50.0, dt), 0.0);  // a shaft that has long been turning
  double correction = 0.0;
  for (int k = 1; k < 80'000; ++k) correction = one.step(-50.0 + 200.0 * k * dt, dt);
  EXPECT_NEAR(correction, 0.0, 1e-6);
}

TEST(AntiJerk, IsBoundedByItsShareAndByTheAvailableTorque) {
  AntiJerk<double> one{{.gain = 100.0, .corner = 1.0, .share = 0.2}};
  one.step(0.0, dt);
  one.step(-10.0, dt);  // asks for 1000 N·m more
  EXPECT_DOUBLE_EQ(one.corrected(30.0, 50.0, {-80.0, 80.0}), 40.0);
  EXPECT_DOUBLE_EQ(one.corrected(30.0, 50.0, {-80.0, 33.0}), 33.0);
  EXPECT_DOUBLE_EQ(one.corrected(-30.0, 50.0, {-80.0, 80.0}), -20.0);
  EXPECT_DOUBLE_EQ(one.corrected(30.0, 0.0, {-80.0, 80.0}), 30.0);
  // A ramp to zero may be beyond what has just become available.
  EXPECT_DOUBLE_EQ(one.corrected(30.0, 50.0, {-20.0, 20.0}), 30.0);
  one.step(50.0, dt);
  EXPECT_DOUBLE_EQ(one.corrected(30.0, 50.0, {-80.0, 80.0}), 20.0);
}

TEST(AntiJerk, WhatMakesNoCorrectionIsRefused) {
  EXPECT_EQ((AntiJerkParameters<>{.gain = 3.0}.validate()), nullptr);
  EXPECT_NE((AntiJerkParameters<>{.gain = -1.0}.validate()), nullptr);
  EXPECT_NE((AntiJerkParameters<>{.gain = NAN}.validate()), nullptr);
  EXPECT_NE((AntiJerkParameters<>{.corner = 0.0}.validate()), nullptr);
  EXPECT_NE((AntiJerkParameters<>{.share = 0.0}.validate()), nullptr);
  EXPECT_NE((AntiJerkParameters<>{.share = 1.1}.validate()), nullptr);
  Drive<>::Parameters p;
  p.anti_jerk.gain = 0.2501 * p.motor.capability.machine.inertia / dt;
  EXPECT_NE(p.validate(), nullptr);
  p.anti_jerk.gain = 0.2499 * p.motor.capability.machine.inertia / dt;
  EXPECT_EQ(p.validate(), nullptr);
}

/// A drive whose measured speed a test moves.
template <class T>
class AntiJerkOf : public testing::Test {
 protected:
  AntiJerkOf() {
    Measurement<T>& m = measurement;
    m.u_dc = T(530);
    m.i_abc = {T(5), T(-2), T(-3)};
    m.omega_m = T(10);
    controller.estimate().psi_s = {T(1.1), T(0)};
  }
  static typename Drive<T>::Parameters parameters(T gain) {
    typename Drive<T>::Parameters p;
    p.anti_jerk = {.gain = gain, .corner = T(1), .share = T(0.1)};
    return p;
  }
  void receive(T torque, bool enable) {
    TorqueCommand<T>& c = request.command;
    c.torque = torque;
    c.torque_limit = T(150);
    c.enable = enable;
    c.received_ns = t_ns;
    c.e2e = E2eState::valid;
    ++c.sequence;
  }
  Telemetry<T> step(Drive<T>& drive) {
    const Telemetry<T> telemetry = drive.step(t_ns, measurement, request).telemetry;
    t_ns += period_ns;
    return telemetry;
  }
  void start(Drive<T>& drive, T torque) {
    step(drive);
    receive(T(0), false);
    step(drive);
    receive(torque, true);
    for (int k = 0; k < 40; ++k) step(drive);
    ASSERT_EQ(drive.state(), DriveState::torque);
  }

  test::FakeController<T> controller{};
  Measurement<T> measurement{};
  DriveRequest<T> request{};
  std::int64_t t_ns{5 * ms};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(AntiJerkOf, Scalars);

TYPED_TEST(AntiJerkOf, IsPartOfTheReferenceThatTheDrivePublishes) {
  using T = TypeParam;
  Drive<T> drive{this->parameters(T(2)), this->controller};
  this->start(drive, T(0));
  this->measurement.omega_m = T(11);
  const Telemetry<T> t = this->step(drive);
  EXPECT_NEAR(t.torque_reference, T(-2), T(0.01));
  EXPECT_EQ(this->controller.last_reference.torque, t.torque_reference);
  EXPECT_EQ(t.state, DriveState::torque);
  this->measurement.omega_m = T(-2);  // more than the share of 150 N·m
  EXPECT_NEAR(this->step(drive).torque_reference, T(15), T(0.01));
}

TYPED_TEST(AntiJerkOf, IsNoneByDefault) {
  using T = TypeParam;
  Drive<T> drive{{}, this->controller};
  this->start(drive, T(20));
  this->measurement.omega_m = T(11);
  EXPECT_EQ(this->step(drive).torque_reference, T(20));
}

TYPED_TEST(AntiJerkOf, EndsWithARampToZero) {
  using T = TypeParam;
  Drive<T> drive{this->parameters(T(100)), this->controller};
  this->start(drive, T(20));
  this->request.shutdown = true;
  T speed = T(10);
  for (int k = 0; k < 600 && drive.state() != DriveState::shutdown; ++k) {
    speed = -speed;  // asks for 15 N·m, one way and the other
    this->measurement.omega_m = speed;
    const T reference = this->step(drive).torque_reference;
    ASSERT_LE(std::abs(reference), T(22));
    ASSERT_GE(reference, T(0));
  }
  EXPECT_EQ(drive.state(), DriveState::shutdown);
  EXPECT_EQ(this->controller.last_reference.torque, T(0));
}

TYPED_TEST(AntiJerkOf, IsNoneWithoutTorque) {
  using T = TypeParam;
  Drive<T> drive{this->parameters(T(2)), this->controller};
  this->start(drive, T(20));
  this->request.external.set(Fault::bus_off);
  this->measurement.omega_m = T(12);
  EXPECT_EQ(this->step(drive).torque_reference, T(0));
  EXPECT_EQ(drive.state(), DriveState::fault);
}

}  // namespace
}  // namespace sextant
