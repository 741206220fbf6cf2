#include <chrono>
#include <cstdint>
#include <map>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/comms/status_encoder.hpp"
#include "virtual_time/virtual_rig.hpp"

namespace sextant::test {
namespace {

TEST(VirtualRun, ADriveFollowsAVehicleThroughTheHandShake) {
  VirtualRig rig;
  ASSERT_TRUE(rig.start());
  EXPECT_EQ(rig.now().torque_reference, 15.0);
  EXPECT_EQ(rig.vehicle.status()->state, DriveState::torque);
  EXPECT_FALSE(rig.now().latched.any());
  EXPECT_NEAR(rig.plant().tau_e(), 15.0, 8.0);  // one sample of sampled direct torque control
}

TEST(VirtualRun, AVehicleThatHasFinishedLeavesTheDriveReady) {
  VirtualRig rig{{.vehicle_duration_ns = 100 * ms}};
  rig.run_until(400 * ms);
  EXPECT_EQ(rig.vehicle.phase(), VirtualVehicle::Phase::done);
  EXPECT_EQ(rig.now().state, DriveState::ready);
  ASSERT_TRUE(rig.vehicle.enabled_ns());
  // Disables in the hand-shake, enables over the duration with both ends, disables at the end.
  const auto disables = std::uint64_t(*rig.vehicle.enabled_ns() / (10 * ms));
  EXPECT_EQ(rig.bus.counts().put, disables + 11 + 10);
}

TEST(VirtualRun, ADriveFollowsTheVehicleOfItsOwnOffsetOnly) {
  const IdentifierOffset moved{96};
  VirtualRig together{{.vehicle = {.identifier_offset = moved}, .identifier_offset = moved}};
  EXPECT_TRUE(together.start());
  EXPECT_EQ(together.vehicle.status()->state, DriveState::torque);
  VirtualRig apart{{.identifier_offset = moved}};
  EXPECT_FALSE(apart.start());
  EXPECT_EQ(apart.now().command_sequence, 0U);
  EXPECT_EQ(apart.now().command_rejected, 0U);
  EXPECT_FALSE(apart.vehicle.status());
}

TEST(VirtualRun, StatusFramesKeepTheirCycleTimes) {
  VirtualRig rig;
  std::map<std::uint32_t, std::int64_t> sent;
  rig.bus.listen([&](const CanFrame& frame) { ++sent[frame.id]; });
  rig.run_until(2000 * ms - 1);
  for (std::size_t i = 0; i < status_message_count; ++i) {
    const auto message = static_cast<StatusMessage>(i);
    EXPECT_EQ(sent[StatusEncoder{}.frame(message, {}, {}).id], 2000 * ms / cycle_time_ns(message)) << i;
  }
}

TEST(VirtualRun, ShutdownRampsToZeroTurnsTheGatesOffAndReportsIt) {
  VirtualRig rig;
  ASSERT_TRUE(rig.start());
  rig.ecu.shut_down();
  const std::int64_t asked_ns = rig.clock.now_ns();
  while (!rig.ecu.stopped() && rig.timeline.step(asked_ns + 1000 * ms)) {
  }
  ASSERT_TRUE(rig.ecu.stopped());
  EXPECT_LE(rig.clock.now_ns(), asked_ns + 100 * ms);
  EXPECT_EQ(rig.now().pattern.last_state(), gates_off);
  EXPECT_EQ(rig.vehicle.status()->state, DriveState::shutdown);
  const std::uint64_t periods = rig.recorder.periods();
  rig.run_for(100 * ms);
  EXPECT_EQ(rig.recorder.periods(), periods);
}

TEST(VirtualRun, ATransmitQueueThatIsFullStopsNothing) {
  VirtualRig rig;
  ASSERT_TRUE(rig.start());
  rig.bus.add({.kind = BusEventKind::refuse_transmit,
               .begin_ns = rig.clock.now_ns(),
               .end_ns = rig.clock.now_ns() + 50 * ms});
  rig.run_for(100 * ms);
  EXPECT_EQ(rig.now().state, DriveState::torque);
  EXPECT_EQ(rig.bus.stats().send_dropped, 12U);  // three messages each at 210, 220, 230 and 240 ms
  EXPECT_EQ(rig.vehicle.status()->state, DriveState::torque);
}

TEST(VirtualRun, TheWallClockDoesNotMatter) {
  VirtualRig first{{.wake_every_periods = 40}};
  VirtualRig second{{.wake_every_periods = 40}};
  first.run_until(300 * ms);
  for (int k = 1; k <= 3; ++k) {
    second.run_until(k * 100 * ms);
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }
  EXPECT_EQ(first.recorder.telemetry_digest(), second.recorder.telemetry_digest());
  EXPECT_EQ(first.recorder.frames_digest(), second.recorder.frames_digest());
}

TEST(VirtualRun, ARecordingOfARunMakesTheSameRun) {
  VirtualRigParameters p{.bus = draw({.seed = 5, .begin_ns = 200 * ms, .end_ns = 500 * ms})};
  // A log is good to the microsecond.
  for (BusEvent& event : p.bus) {
    event.end_ns = event.end_ns / 1000 * 1000;
    event.delay_ns = event.delay_ns / 1000 * 1000;
    event.begin_ns = event.begin_ns / 1000 * 1000;
  }
  VirtualRig rig{p};
  std::vector<LoggedFrame> log;
  rig.bus.watch([&](const CanFrame& frame) {
    log.push_back(
        parse_candump(format_candump({1'700'000'000'000'000'000 + frame.received_ns, "can0", frame})));
  });
  rig.run_until(600 * ms);
  ASSERT_GT(rig.bus.counts().lost + rig.bus.counts().corrupted + rig.bus.counts().delayed, 0U);

  VirtualRig again{{.log = log}};
  EXPECT_EQ(again.replay.left_out(), rig.recorder.frames());
  again.run_until(600 * ms);
  EXPECT_EQ(again.recorder.telemetry_digest(), rig.recorder.telemetry_digest());
  EXPECT_EQ(again.recorder.frames_digest(), rig.recorder.frames_digest());
}

}  // namespace
}  // namespace sextant::test
