// The control thread's loop, whole, with every allocation of the process's heap counted.

#include <cstdint>
#include <memory>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/realtime/latest_value.hpp"
#include "sextant/realtime/ring.hpp"
#include "support/allocation_counter.hpp"

namespace sextant {
namespace {

/// The newest request, from the cell that a receive thread would fill.
struct CellCommands {
  LatestValue<DriveRequest<double>> cell{};
  DriveRequest<double> latest(std::int64_t) noexcept { return cell.latest(); }
};

/// The drive as the live control thread runs it: commands from a cell, telemetry into a ring.
class ControlThread {
 public:
  explicit ControlThread(const RigParameters& parameters)
      : parameters_{parameters},
        stage_{parameters_.stage, parameters_.load},
        controller_{parameters_.controller},
        drive_{parameters_.drive, controller_} {}

  /// Runs with a new command every 10 ms; the ring's reader takes what there is at the same instants. Gates
  /// are off in a tenth of the time, so that diode events are among what is counted.
  void run(std::int64_t periods) {
    for (std::int64_t k = 0; k < periods; ++k) {
      if (k % 400 == 0) exchange();
      run_cycle(t_ns_, stage_.io(), commands_, drive_, telemetry_);
      t_ns_ += DriveRig::period_ns;
    }
  }

  [[nodiscard]] double peak_torque() const noexcept { return peak_torque_; }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return telemetry_.dropped(); }

 private:
  void exchange() {
    ++sequence_;
    DriveRequest<double> request;
    request.command = {.torque = sequence_ % 4 < 2 ? 15.0 : -15.0,
                       .torque_limit = 100.0,
                       .enable = sequence_ % 10 != 1,
                       .received_ns = t_ns_,
                       .sequence = sequence_,
                       .e2e = E2eState::valid};
    commands_.cell.store(request);
    Telemetry<double> t;
    while (telemetry_.pop(t)) peak_torque_ = std::max(peak_torque_, t.torque);
  }

  RigParameters parameters_;
  SimulatedPowerStage stage_;
  DirectTorqueController<double> controller_;
  Drive<double> drive_;
  CellCommands commands_{};
  Ring<Telemetry<double>> telemetry_{256};
  std::int64_t t_ns_{0};
  std::uint64_t sequence_{0};
  double peak_torque_{0.0};
};

RigParameters moved_by(IntegratorKind integrator) {
  RigParameters p = RigParameters::at_speed(30.0, integrator);
  p.drive.command.lost_ns = 1'000'000'000;
  return p;
}

std::uint64_t allocations_of(const RigParameters& parameters, std::int64_t periods) {
  const auto thread = std::make_unique<ControlThread>(parameters);
  const std::uint64_t before = testing::allocations();
  thread->run(periods);
  const std::uint64_t after = testing::allocations();
  EXPECT_GT(thread->peak_torque(), 10.0) << "the drive has not worked";
  EXPECT_GT(thread->dropped(), 0U) << "the ring was never full";
  return after - before;
}

TEST(Allocation, ASeededOneIsCounted) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  struct LeakyTelemetry {
    std::unique_ptr<Telemetry<double>> last{};
    void push(const Telemetry<double>& t) { last = std::make_unique<Telemetry<double>>(t); }
  };
  DriveRig rig;
  LeakyTelemetry leaky;
  const std::uint64_t before = testing::allocations();
  for (int k = 0; k < 3; ++k) run_cycle(k * DriveRig::period_ns, rig.io(), rig, rig.drive(), leaky);
  EXPECT_EQ(testing::allocations() - before, 3U);
}

TEST(Allocation, NoneInAMillionPeriodsWithTheFixedStep) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  EXPECT_EQ(allocations_of(moved_by(IntegratorKind::fixed), 1'000'000), 0U);
}

TEST(Allocation, NoneInAHundredThousandPeriodsWithCvode) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  EXPECT_EQ(allocations_of(moved_by(IntegratorKind::cvode), 100'000), 0U);
}

TEST(Allocation, NoneInAHundredThousandPeriodsWithTheOthers) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  EXPECT_EQ(allocations_of(moved_by(IntegratorKind::exact), 100'000), 0U);
  EXPECT_EQ(allocations_of(moved_by(IntegratorKind::erk), 100'000), 0U);
}

TEST(Allocation, NoneInAHundredThousandPeriodsWithSensorsAndAnOpenPhase) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  for (const IntegratorKind integrator :
       {IntegratorKind::fixed, IntegratorKind::cvode, IntegratorKind::exact, IntegratorKind::erk}) {
    RigParameters p = moved_by(integrator);
    p.stage.io.sensors.sampling_lead_ns = 5'000;
    p.stage.io.sensors.current = {.noise = 0.1, .range = 400, .bits = 12};
    p.stage.io.sensors.encoder.lines = 1024;
    p.stage.io.fault = {.kind = PlantFaultKind::open_phase, .at_ns = 2'000'000'000};
    EXPECT_EQ(allocations_of(p, 100'000), 0U);
  }
}

}  // namespace
}  // namespace sextant
