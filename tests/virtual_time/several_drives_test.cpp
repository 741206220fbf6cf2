#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include <gtest/gtest.h>

#include "virtual_time/virtual_rig.hpp"

namespace sextant::test {
namespace {

constexpr std::array torques{5.0, 10.0, -8.0, 15.0};  // that the vehicles ask for [N·m]

/// A drive with its plant, on a bus with others.
class OneOfSeveral {
 public:
  OneOfSeveral(std::size_t number, const VirtualClock& clock, VirtualCanBus& bus,
               const PlantFaultParameters& fault = {})
      : stage_{stage_parameters(fault), {.imposed_speed = ProfileParameters{.value = 40.0}}},
        unit{config(number), stage_.io(), bus},
        vehicle{{.identifier_offset = unit.config().can.identifier_offset},
                clock,
                bus,
                [number](std::int64_t) { return torques[number]; }},
        recorder{40, {.period = [this](const Telemetry<double>&) { add_torque(); }}} {}

  /// Of the plant, since the call before. [N·m]
  [[nodiscard]] double take_mean_torque() {
    const double mean = sum_ / double(periods_);
    sum_ = 0.0;
    periods_ = 0;
    return mean;
  }

 private:
  static SimulatedPowerStage::Parameters stage_parameters(const PlantFaultParameters& fault) {
    SimulatedPowerStage::Parameters stage = shipped_drive().plant;
    stage.integrator = IntegratorKind::fixed;
    stage.io.fault = fault;
    return stage;
  }
  static EcuConfig config(std::size_t number) {
    return {.drive_id = int(number) + 1,
            .drive = shipped_drive(),
            .realtime = {.wake_every_periods = 1},
            .can = {.identifier_offset = {IdentifierOffset::step * int(number)}}};
  }
  void add_torque() {
    sum_ += stage_.io().plant().tau_e();
    ++periods_;
  }

  SimulatedPowerStage stage_;
  double sum_{0.0};
  std::uint64_t periods_{0};

 public:
  ecu::DriveUnit unit;
  VirtualVehicle vehicle;
  RunRecorder recorder;
};

/// Drives of these numbers on one bus and one timeline; number 1 may have a fault.
class SeveralDrives {
 public:
  explicit SeveralDrives(const std::vector<std::size_t>& numbers, const PlantFaultParameters& fault = {},
                         OnFault on_fault = OnFault::others_go_on)
      : ecu_{make(numbers, fault), clock_, bus_, on_fault} {
    timeline_.add(bus_.party());
    for (OneOfSeveral& drive : drives) timeline_.add(drive.vehicle.party());
    ecu_.join(timeline_);
  }

  void run_until(std::int64_t t_ns) { timeline_.run_until(t_ns); }
  [[nodiscard]] const Telemetry<double>& now(std::size_t k) { return ecu_.drive(k).telemetry(); }

  [[nodiscard]] const ecu::VirtualEcu& ecu() const noexcept { return ecu_; }

  std::deque<OneOfSeveral> drives{};

 private:
  std::vector<ecu::VirtualUnit::Parts> make(const std::vector<std::size_t>& numbers,
                                            const PlantFaultParameters& fault) {
    std::vector<ecu::VirtualUnit::Parts> parts;
    for (const std::size_t number : numbers) {
      OneOfSeveral& drive =
          drives.emplace_back(number, clock_, bus_, number == 1 ? fault : PlantFaultParameters{});
      parts.push_back({.unit = drive.unit, .recorder = drive.recorder});
    }
    return parts;
  }

  VirtualClock clock_{};
  VirtualCanBus bus_{clock_};
  VirtualTimeline timeline_{clock_};
  ecu::VirtualEcu ecu_;
};

// The mean over 200 ms at constant speed and torque is the reference but for the band of the comparator and
// the estimate: the shipped drive is within 1 N·m there.
TEST(SeveralDrives, EachMakesItsTorqueAndTheOthersGoOnWhereASensorFails) {
  SeveralDrives four{{0, 1, 2, 3}, {.kind = PlantFaultKind::current_zero, .phase = 0, .at_ns = 400 * ms}};
  four.run_until(200 * ms);
  for (OneOfSeveral& drive : four.drives) (void)drive.take_mean_torque();
  four.run_until(400 * ms - 1);
  for (std::size_t k = 0; k < torques.size(); ++k) {
    EXPECT_EQ(four.now(k).state, DriveState::torque) << k;
    EXPECT_NEAR(four.drives[k].take_mean_torque(), torques[k], 1.0) << k;
  }
  four.run_until(600 * ms);
  for (OneOfSeveral& drive : four.drives) (void)drive.take_mean_torque();
  four.run_until(800 * ms);
  for (std::size_t k = 0; k < torques.size(); ++k) {
    const bool has_failed = k == 1;
    EXPECT_EQ(four.now(k).state, has_failed ? DriveState::fault : DriveState::torque) << k;
    EXPECT_EQ(four.now(k).latched.any(), has_failed) << k;
    EXPECT_NEAR(four.drives[k].take_mean_torque(), has_failed ? 0.0 : torques[k], 1.0) << k;
  }
  EXPECT_EQ(four.now(1).pattern.last_state(), gates_off);
}

// By the ramp of command.zero_ramp_ms, as at SIGTERM.
TEST(SeveralDrives, AFaultRampsAllToZeroAndShutsThemDownWhereTheKeySaysSo) {
  const PlantFaultParameters fault{.kind = PlantFaultKind::current_zero, .phase = 0, .at_ns = 400 * ms};
  SeveralDrives three{{0, 1, 2}, fault, OnFault::all_shut_down};
  three.run_until(400 * ms - 1);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(three.now(k).state, DriveState::torque) << k;
  EXPECT_FALSE(three.ecu().has_ended());
  three.run_until(700 * ms);
  EXPECT_TRUE(three.ecu().has_ended());
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(three.now(k).state, DriveState::shutdown) << k;
    EXPECT_EQ(three.now(k).pattern.last_state(), gates_off) << k;
    EXPECT_EQ(three.now(k).latched.any(), k == 1) << k;
  }
}

// The watchdog turns the gates of the drive off whose control thread hangs; the others must not wait for it.
TEST(FaultReaction, AControlThreadThatHangsShutsAllDown) {
  const VirtualClock clock;
  VirtualCanBus bus{clock};
  OneOfSeveral works{0, clock, bus};
  OneOfSeveral hangs{1, clock, bus};
  ecu::FaultReaction all{OnFault::all_shut_down, {&works.unit, &hangs.unit}};
  ecu::FaultReaction none{OnFault::others_go_on, {&works.unit, &hangs.unit}};
  const std::int64_t timeout_ns = hangs.unit.config().realtime.watchdog_ns;
  for (OneOfSeveral* drive : {&works, &hangs}) drive->unit.shared().beat(ms);
  all.poll(ms + timeout_ns);
  EXPECT_FALSE(all.has_ended());
  EXPECT_EQ(all.problem(), "");
  works.unit.shared().beat(ms + timeout_ns);
  none.poll(ms + timeout_ns + 1);
  EXPECT_FALSE(none.has_ended());
  EXPECT_FALSE(works.unit.shared().shutdown.load());
  all.poll(ms + timeout_ns + 1);
  EXPECT_EQ(all.problem(), "drive 2 went to FAULT (WATCHDOG): every drive has shut down (on_fault)");
  for (OneOfSeveral* drive : {&works, &hangs}) EXPECT_TRUE(drive->unit.shared().shutdown.load());
}

// Neither the frames of the others nor a fault of one reaches a drive.
TEST(SeveralDrives, EachIsBitByBitTheDriveThatItIsAlone) {
  const PlantFaultParameters fault{.kind = PlantFaultKind::current_zero, .phase = 0, .at_ns = 200 * ms};
  SeveralDrives four{{0, 1, 2, 3}, fault};
  four.run_until(300 * ms);
  for (const std::size_t number : {std::size_t{1}, std::size_t{3}}) {
    SeveralDrives alone{{number}, fault};
    alone.run_until(300 * ms);
    EXPECT_EQ(four.drives[number].recorder.telemetry_digest(), alone.drives[0].recorder.telemetry_digest());
    EXPECT_EQ(four.drives[number].recorder.frames_digest(), alone.drives[0].recorder.frames_digest());
    EXPECT_GT(alone.drives[0].recorder.frames(), 0U);
  }
}

}  // namespace
}  // namespace sextant::test
