// What a drive does after a trip by measurements that cannot be: reset, disable, enable on the turning
// machine.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "sextant/drive/run_cycle.hpp"
#include "sim/machine_run.hpp"

namespace sextant {
namespace {

using Spoil = std::function<void(Measurement<double>&)>;

/// A drive with its plant, whose measurements may be spoilt.
class TripRig final : public DriveIo<double> {
 public:
  TripRig(const TestMachine& machine, const MachineRun& r)
      : config_{machine_config(machine, r)},
        stage_{config_.drive.plant, config_.scenario.load},
        controller_{make_controller(config_.drive)},
        drive_{config_.drive.drive, *controller_} {}

  Measurement<double> read(std::int64_t t_ns) noexcept override {
    Measurement<double> m = stage_.io().read(t_ns);
    if (spoil) spoil(m);
    return m;
  }
  void write(const GatePattern& pattern) noexcept override { stage_.io().write(pattern); }

  DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    DriveRequest<double> request;
    request.command = {.torque = torque,
                       .torque_limit = 1e6,
                       .enable = enable,
                       .fault_reset = fault_reset,
                       .received_ns = t_ns,
                       .sequence = ++sequence_,
                       .e2e = E2eState::valid};
    return request;
  }
  void push(const Telemetry<double>&) noexcept {}

  void run(double seconds) {
    const std::int64_t end = t_ns_ + std::llround(seconds * 1e9);
    for (; t_ns_ < end; t_ns_ += config_.drive.drive.period_ns) {
      run_cycle(t_ns_, *this, *this, drive_, *this);
      peak_current = std::max(peak_current, magnitude(stage_.io().plant().i_s()));
    }
  }
  /// Until the drive makes torque; false where it does not within that time [s].
  [[nodiscard]] bool start(double within) {
    enable = false;
    run(3e-3);
    enable = true;
    for (double waited = 0.0; waited < within && !makes_torque(drive_.state()); waited += 1e-3) run(1e-3);
    return makes_torque(drive_.state());
  }
  /// Until the fault is gone; readings of the gates' rest are forgotten within 30 ms.
  void reset() {
    enable = false;
    fault_reset = true;
    for (int n = 0; n < 100 && drive_.state() == DriveState::fault; ++n) run(1e-3);
    fault_reset = false;
  }
  [[nodiscard]] double mean_torque(double seconds) {
    double sum = 0.0;
    int n = 0;
    for (double t = 0.0; t < seconds; t += double(config_.drive.drive.period_ns) * 1e-9, ++n) {
      run(double(config_.drive.drive.period_ns) * 1e-9);
      sum += stage_.io().plant().tau_e();
    }
    return sum / n;
  }
  [[nodiscard]] DriveState state() const { return drive_.state(); }
  [[nodiscard]] const ProtectionLimits<>& limits() const { return config_.drive.drive.protection; }

  Spoil spoil{};
  double torque{};
  bool enable{};
  bool fault_reset{};
  double peak_current{};

 private:
  ScenarioConfig config_;
  MeteredPowerStage stage_;
  std::unique_ptr<Controller<double>> controller_;
  Drive<double> drive_;
  std::int64_t t_ns_{};
  std::uint64_t sequence_{};
};

/// What spoils the measurements, and for how long [s]; 0: one period.
struct BadReadings {
  const char* name;
  Spoil spoil;
  double seconds;
};

/// trip: level of OVER_CURRENT [A].
std::array<BadReadings, 6> bad_readings(double trip) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto currents = [](double i) {
    return [i](Measurement<double>& m) { m.i_abc = {i, -0.5 * i, -0.5 * i}; };
  };
  return {{{"a current of 1e308 A", currents(1e308), 0.0},
           {"a link of 1e300 V", [](Measurement<double>& m) { m.u_dc = 1e300; }, 0.0},
           {"a speed of 1e6 rad/s", [](Measurement<double>& m) { m.omega_m = 1e6; }, 0.0},
           {"a speed that is no number", [](Measurement<double>& m) { m.omega_m = nan; }, 0.0},
           {"currents at ten times their range", currents(100 * trip), 0.4},
           {"currents at five times their trip", currents(5 * trip), 0.4}}};
}

// A model of the flux that had taken up such a reading would start from a flux that is not there, or would
// have none in a machine that still has its own.
TEST(AfterTrip, TheNextStartIsThatOfADriveWithoutFault) {
  for (const TestMachine& machine : {test_machines[0], test_machines[1], test_machines[3]}) {
    for (const char* controller : {"dtc", "foc"}) {
      const MachineRun run{.controller = controller, .period_us = 100, .omega_m = 0.3 * machine.base_speed()};
      const double tau_r = machine.parameters.tau_r();
      for (const BadReadings& fault : bad_readings(TripRig{machine, run}.limits().over_current)) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << fault.name);
        TripRig rig{machine, run};
        rig.torque = 0.3 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
        ASSERT_TRUE(rig.start(3 * tau_r));
        rig.run(0.1);
        const double first_peak = rig.peak_current;
        rig.spoil = fault.spoil;
        rig.run(std::max(fault.seconds, 1e-6));
        rig.spoil = {};
        ASSERT_EQ(rig.state(), DriveState::fault);
        rig.peak_current = 0.0;
        rig.reset();
        ASSERT_TRUE(rig.start(3 * tau_r));
        EXPECT_LT(rig.peak_current, 1.2 * first_peak);
        rig.run(0.02);
        EXPECT_NEAR(rig.mean_torque(0.05), rig.torque, 0.03 * rig.torque);
        EXPECT_EQ(rig.state(), DriveState::torque);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
