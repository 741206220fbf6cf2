// The anti-jerk correction of a whole drive on a load behind a soft shaft, against the eigenvalues of the
// linear equations of two masses.
#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "run/machine_run.hpp"
#include "sextant/drive/run_cycle.hpp"

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
using Shaft = Driveline<double>;

/// Two masses, their shaft, and the correction −g (s/(s + ω_c))² omega_m on the motor.
struct TwoMasses {
  double motor, load, stiffness, damping;  // [kg·m²], [N·m/rad], [N·m·s/rad]

  /// Eigenvalue of the oscillation. [1/s]
  [[nodiscard]] std::complex<double> oscillation(const AntiJerkParameters<>& p) const {
    const double corner = 2 * pi * p.corner, g = p.gain;
    Eigen::Matrix<double, 5, 5> a;  // of twist, both speeds, and what the high-passes take away
    a << 0, 1, -1, 0, 0,            //
        -stiffness / motor, -(damping + g) / motor, damping / motor, g / motor, g / motor,  //
        stiffness / load, damping / load, -damping / load, 0, 0,                            //
        0, corner, 0, -corner, 0,                                                           //
        0, corner, 0, -corner, -corner;
    const auto values = Eigen::EigenSolver<Eigen::Matrix<double, 5, 5>>{a}.eigenvalues();
    std::complex<double> found{};
    for (const std::complex<double>& value : values)
      if (value.imag() > found.imag()) found = value;
    return found;
  }
};

/// A drive on its shaft, commanded by hand.
class ShaftRig {
 public:
  ShaftRig(const TestMachine& machine, const char* controller, const TwoMasses& masses,
           const AntiJerkParameters<>& anti_jerk)
      : config_{config(machine, controller, masses, anti_jerk)},
        stage_{config_.drive.plant, {}},
        controller_{make_controller(config_.drive)},
        drive_{config_.drive.drive, *controller_} {}

  void run(double seconds) {
    const std::int64_t end = t_ns_ + std::llround(seconds * 1e9);
    for (; t_ns_ < end; t_ns_ += config_.drive.drive.period_ns) {
      run_cycle(t_ns_, stage_.io(), *this, drive_, *this);
      const auto y = PowerStageOf<Shaft>::Plant::states_of<Shaft>(stage_.io().plant().state());
      slips.push_back(stage_.io().plant().omega_m() - y[Shaft::load_speed]);
      correction = std::max(correction, std::abs(telemetry.torque_reference - torque));
    }
  }
  DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    DriveRequest<double> request;
    request.command = {.torque = torque,
                       .torque_limit = 1e6,
                       .enable = t_ns > 1'000'000,
                       .received_ns = t_ns,
                       .sequence = ++sequence_,
                       .e2e = E2eState::valid};
    return request;
  }
  void push(const Telemetry<double>& t) noexcept { telemetry = t; }

  [[nodiscard]] double period_s() const { return double(config_.drive.drive.period_ns) * 1e-9; }

  double torque{};
  double correction{};          ///< largest one since it was set to zero [N·m]
  std::vector<double> slips{};  ///< speed of the motor less that of the load, each period [rad/s]
  Telemetry<double> telemetry{};

 private:
  static ScenarioConfig config(const TestMachine& machine, const char* controller, const TwoMasses& masses,
                               const AntiJerkParameters<>& anti_jerk) {
    ScenarioConfig c = machine_config(machine, {.controller = controller, .period_us = 50});
    c.drive.plant.driveline = {
        .inertia = masses.load, .stiffness = masses.stiffness, .damping = masses.damping};
    c.drive.drive.anti_jerk = anti_jerk;
    return c;
  }

  ScenarioConfig config_;
  PowerStageOf<Shaft> stage_;
  std::unique_ptr<Controller<double>> controller_;
  Drive<double> drive_;
  std::int64_t t_ns_{};
  std::uint64_t sequence_{};
};

/// Decay [1/s] and frequency [rad/s] of an oscillation by its first six extrema, over two periods. The way
/// from one to the next leaves out what moves slowly beside it.
std::complex<double> measured_oscillation(const std::vector<double>& x, double period_s) {
  constexpr double least_apart_s = 0.03;
  std::vector<std::size_t> at;
  for (std::size_t k = 1; k + 1 < x.size() && at.size() < 6; ++k) {
    const bool is_apart = at.empty() || double(k - at.back()) * period_s > least_apart_s;
    if (is_apart && x[k] != x[k - 1] && (x[k] - x[k - 1]) * (x[k + 1] - x[k]) <= 0) at.push_back(k);
  }
  if (at.size() < 6) return {NAN, NAN};
  const double seconds = double(at[4] - at[0]) * period_s;
  return {std::log((x[at[5]] - x[at[4]]) / (x[at[1]] - x[at[0]])) / seconds, 4 * pi / seconds};
}

/// 8 Hz with a damping ratio of 0.01; the load has four times the motor's inertia.
TwoMasses masses_of(const TestMachine& machine) {
  const double motor = machine.parameters.inertia, load = 4 * motor, mobility = 1 / motor + 1 / load;
  const double omega = 2 * pi * 8;
  return {motor, load, omega * omega / mobility, 2 * 0.01 * omega / mobility};
}

// Tip-in, and tip-out to zero torque, of which the correction is all that is left.
TEST(AntiJerkRun, TheShaftSwingsOutAsTheEigenvaluesOfTwoMassesSay) {
  for (const TestMachine& machine : {test_machines[1], test_machines[2], test_machines[5]}) {
    const TwoMasses masses = masses_of(machine);
    for (const char* controller : {"foc", "pwm_dtc"}) {
      for (const double ratio : {0.0, 0.08, 0.16}) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << ratio);
        const double gain = 2 * ratio * 2 * pi * 8 * 1.25 * masses.motor;
        const AntiJerkParameters<> anti_jerk{.gain = gain, .corner = 1.0, .share = 0.5};
        ShaftRig rig{machine, controller, masses, anti_jerk};
        rig.run(3 * machine.parameters.tau_r());
        ASSERT_EQ(rig.telemetry.state, DriveState::torque);
        const std::complex<double> expected = masses.oscillation(anti_jerk);
        for (const double torque : {0.2, 0.0}) {
          rig.torque = torque * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
          rig.run(0.02);
          rig.slips.clear();
          rig.run(0.4);
          const std::complex<double> found = measured_oscillation(rig.slips, rig.period_s());
          EXPECT_NEAR(found.real(), expected.real(), 0.03 * std::abs(expected.real()) + 0.03);
          EXPECT_NEAR(found.imag(), expected.imag(), 0.01 * expected.imag());
        }
        EXPECT_FALSE(rig.telemetry.latched.any());
        EXPECT_EQ(rig.telemetry.state, DriveState::torque);
      }
    }
  }
}

// The ratio that a gain adds is that of friction at the motor: g/(2 ω J) by the load's share of both
// inertias.
TEST(AntiJerkRun, WithoutCorrectionAndFarAboveTheCornerTheEigenvaluesAreThoseByHand) {
  const TwoMasses masses = masses_of(test_machines[1]);
  const double omega = 2 * pi * 8;
  const std::complex<double> bare = masses.oscillation({});
  EXPECT_NEAR(bare.real(), -0.01 * omega, 1e-9 * omega);
  EXPECT_NEAR(bare.imag(), omega * std::sqrt(1 - 1e-4), 1e-9 * omega);
  const double gain = 2 * 0.01 * omega * 1.25 * masses.motor;
  const std::complex<double> damped = masses.oscillation({.gain = gain, .corner = 0.01});
  EXPECT_NEAR(damped.real(), -0.02 * omega, 0.0005 * omega);
}

TEST(AntiJerkRun, StaysWithinItsShareAndIsNoWrongTorque) {
  const TestMachine& machine = test_machines[1];
  const TwoMasses masses = masses_of(machine);
  ShaftRig rig{machine, "foc", masses, {.gain = 20 * masses.motor, .corner = 1.0, .share = 0.05}};
  rig.run(3 * machine.parameters.tau_r());
  const double limit = drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
  for (int n = 0; n < 6; ++n) {
    rig.torque = n % 2 == 0 ? 0.6 * limit : -0.6 * limit;
    rig.run(0.002);
    rig.correction = 0.0;
    rig.run(0.2);
    EXPECT_LE(rig.correction, 0.05 * limit * (1 + 1e-9));
    EXPECT_GT(rig.correction, 0.03 * limit);
  }
  EXPECT_FALSE(rig.telemetry.latched.any());
}

}  // namespace
}  // namespace sextant
