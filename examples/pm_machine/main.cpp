// A permanent-magnet machine with field-oriented control under Sextant's protections, supervision and state
// machine, model in the loop. Exit status 0 where every expectation holds.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "pm_drive_io.hpp"
#include "pm_motor.hpp"
#include "sextant/drive/run_cycle.hpp"

namespace {

using Motor = example::PmMotor<double>;
using PmDrive = sextant::Drive<double, Motor>;

constexpr std::int32_t period_ns = 100'000;
constexpr double u_dc = 540.0;

struct Commands {
  [[nodiscard]] sextant::DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    request.command.received_ns = t_ns;
    request.command.e2e = sextant::E2eState::valid;
    ++request.command.sequence;
    return request;
  }
  sextant::DriveRequest<double> request{};
};

struct LastTelemetry {
  void push(const sextant::Telemetry<double>& t) noexcept { last = t; }
  sextant::Telemetry<double> last{};
};

PmDrive::Parameters parameters(double over_current) {
  PmDrive::Parameters p;
  p.period_ns = p.protection.period_ns = period_ns;
  p.protection.over_current = over_current;
  p.protection.current_range = 100.0;
  // Further on the EMF of the magnets exceeds the link, whose diodes brake, whatever is commanded.
  const double emf_speed =
      u_dc * std::numbers::inv_sqrt3 / (p.motor.machine.pole_pairs * p.motor.machine.psi_m);
  p.protection.over_speed = 0.95 * emf_speed;
  // The checks that foretell currents know induction machines. They get one whose rotor hardly couples: the
  // inductance stands, the rotor's voltage counts as an error. The speed by the slip, the response of a phase
  // and the torque monitor have no equations for this machine and are left out.
  const example::PmParameters<double>& machine = p.motor.machine;
  p.protection.machine = {.r_s = machine.r_s,
                          .r_r = machine.r_s,
                          .l_ls = machine.l_d,
                          .l_lr = machine.l_d,
                          .l_m = 1e-6,
                          .pole_pairs = machine.pole_pairs,
                          .inertia = machine.inertia};
  p.protection.speed_error = 1e6;
  p.protection.current_response = 0.0;
  p.torque_monitor.enabled = false;
  return p;
}

/// A drive on its machine.
struct Rig {
  Rig(double over_current, double omega_m)
      : drive{parameters(over_current)}, io{Motor::Parameters{}.machine, u_dc, omega_m} {}

  void run(double seconds) {
    const std::int64_t end_ns = t_ns + std::llround(seconds * 1e9);
    tau_e = 0.0;
    int periods = 0;
    for (; t_ns < end_ns; ++periods) {
      sextant::run_cycle(t_ns += period_ns, io, commands, drive, telemetry);
      tau_e += io.plant().tau_e();
    }
    tau_e /= periods;
  }
  void command(double torque, bool enable) {
    commands.request.command.torque = torque;
    commands.request.command.torque_limit = 150.0;
    commands.request.command.enable = enable;
  }
  void start(double torque) {
    run(0.005);
    command(0.0, false);
    run(0.005);
    command(torque, true);
    run(0.05);
  }
  /// 3/2 p (psi_m i_q + (L_d − L_q) i_d i_q) of the phase currents and the angle. [N·m]
  [[nodiscard]] double closed_form() const {
    const example::PmParameters<double> m = Motor::Parameters{}.machine;
    const sextant::ThreePhase<double> i = io.plant().i_abc();
    const double theta = m.pole_pairs * io.plant().theta_m();
    const auto along = [&i](double angle) {
      constexpr double third = 2.0 * std::numbers::pi / 3.0;
      return 2.0 / 3.0 *
             (i.a * std::cos(angle) + i.b * std::cos(angle - third) + i.c * std::cos(angle + third));
    };
    const double i_d = along(theta);
    const double i_q = along(theta + 0.5 * std::numbers::pi);
    return 1.5 * m.pole_pairs * (m.psi_m * i_q + (m.l_d - m.l_q) * i_d * i_q);
  }

  PmDrive drive;
  example::PmDriveIo io;
  Commands commands;
  LastTelemetry telemetry;
  std::int64_t t_ns{0};
  double tau_e{};  ///< mean of the last run [N·m]
};

int failures = 0;

void expect(bool holds, const char* what) {
  std::printf("%s %s\n", holds ? "ok    " : "FAILED", what);
  failures += holds ? 0 : 1;
}

void expect_near(double value, double wanted, double tolerance, const char* what) {
  std::printf("%8.3f of %8.3f N·m  ", value, wanted);
  expect(std::abs(value - wanted) <= tolerance, what);
}

void torque_follows() {
  for (const double omega_m : {-100.0, 2.0, 100.0}) {
    Rig rig{12.0, omega_m};
    for (const double torque : {10.0, -10.0}) {
      torque > 0.0 ? rig.start(torque) : rig.command(torque, true);
      rig.run(0.15);  // what the link's limit has left in the current controllers decays with L/R_s
      rig.run(0.02);
      expect(rig.drive.state() == sextant::DriveState::torque, "torque is made");
      expect_near(rig.tau_e, torque, 0.1, "the machine's mean torque");
      expect_near(rig.telemetry.last.torque, rig.closed_form(), 1e-6, "the drive's estimate");
      expect_near(rig.io.plant().tau_e(), rig.closed_form(), 1e-6, "the plant's torque");
    }
  }
}

void current_limits_the_torque() {
  Rig rig{12.0, 50.0};
  rig.start(100.0);
  rig.run(0.05);
  expect(rig.drive.state() == sextant::DriveState::derated, "a torque beyond the current limit is derated");
  const double i_d = -9.0 * std::sin(0.25);
  const double i_q = 9.0 * std::cos(0.25);
  expect_near(rig.tau_e, 4.5 * (0.545 * i_q - 0.015 * i_d * i_q), 0.2, "the torque of 9 A");
}

void over_current_trips() {
  Rig rig{4.0, 100.0};
  rig.start(14.0);
  const sextant::Telemetry<double>& t = rig.telemetry.last;
  expect(rig.drive.state() == sextant::DriveState::fault, "beyond the current trip the drive is in FAULT");
  expect(t.latched.test(sextant::Fault::over_current), "OVER_CURRENT is latched");
  expect(t.first_fault == sextant::Fault::over_current, "and came first");
  const sextant::ThreePhase<double> i = rig.io.plant().i_abc();
  expect(std::abs(i.a) + std::abs(i.b) + std::abs(i.c) < 1e-6, "the gates are off: no current flows");
}

}  // namespace

int main() {
  if (const char* problem = parameters(12.0).validate()) return std::puts(problem), 1;
  torque_follows();
  current_limits_the_torque();
  over_current_trips();
  return failures == 0 ? 0 : 1;
}
