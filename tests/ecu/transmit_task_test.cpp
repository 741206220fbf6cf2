#include "ecu/tasks/transmit_task.hpp"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "ecu/fake_can_bus.hpp"
#include "ecu/tasks/transmit_task.hpp"

namespace sextant::ecu {
namespace {

std::vector<CanFrame> torque_statuses(const std::vector<CanFrame>& frames) {
  const std::uint32_t id = encode(TorqueStatus{}).frame.id;
  std::vector<CanFrame> found;
  for (const CanFrame& frame : frames) {
    if (frame.id == id) found.push_back(frame);
  }
  return found;
}

/// The payload but for its end-to-end bytes.
std::vector<std::uint8_t> content(const CanFrame& frame) {
  return {frame.data.begin() + 2, frame.data.begin() + 8};
}

TEST(TransmitTask, TheLastTorqueStatusSaysShutdownWhenEverThatComes) {
  TorqueStatus last{.state = DriveState::shutdown, .command_counter = {}};
  const std::vector<std::uint8_t> expected = content(encode(last).frame);
  for (int run = 0; run < 5; ++run) {
    SharedState shared{25'000, 40};
    test::FakeCanBus bus;
    TransmitTask transmit{bus, shared};
    Telemetry<double> status;
    status.state = DriveState::torque;
    shared.status.store(status);
    transmit.start(0);
    std::int64_t t_ns = 0;
    while (torque_statuses(bus.sent()).size() <= std::size_t(run)) t_ns = transmit.poll(t_ns) + 1;
    status.state = DriveState::shutdown;
    shared.status.store(status);
    shared.stopped.store(true);
    transmit.send_last(t_ns);
    EXPECT_EQ(content(torque_statuses(bus.sent()).back()), expected) << "run " << run;
  }
}

constexpr std::int64_t ms = 1'000'000;

/// A drive under torque whose control thread beat last at `last_beat_ns`; polled every 5 ms from there on.
class TimedOutControlThread : public testing::Test {
 protected:
  TimedOutControlThread() {
    Telemetry<double> status;
    status.state = DriveState::torque;
    status.lockout = false;
    status.torque = 40.0;
    status.torque_reference = 40.0;
    status.torque_motoring = 100.0;
    status.torque_regenerating = 100.0;
    status.omega_m = 50.0;
    shared.heartbeat_ns.store(last_beat_ns);
    shared.status.store(status);
  }

  /// What is sent in (begin, end], both after the last beat. [ns]
  std::vector<CanFrame> sent_between(std::int64_t begin_ns, std::int64_t end_ns) {
    poll_until(begin_ns);
    const std::size_t before = bus.sent().size();
    poll_until(end_ns);
    const std::vector<CanFrame> all = bus.sent();
    return {all.begin() + std::ptrdiff_t(before), all.end()};
  }

  static constexpr std::int64_t last_beat_ns = 1'000 * ms;

  SharedState shared{25'000, 40};
  test::FakeCanBus bus;
  TransmitTask transmit{bus, shared};

 private:
  void poll_until(std::int64_t end_ns) {
    while (next_ns_ <= last_beat_ns + end_ns) next_ns_ = std::max(transmit.poll(next_ns_), next_ns_ + ms);
  }

  std::int64_t next_ns_{last_beat_ns};
};

DriveState state_of(const CanFrame& frame) {
  return decode_torque_status(frame).value().state;
}

TEST_F(TimedOutControlThread, IsAFaultOnTheBusWithinAHundredMilliseconds) {
  const std::vector<CanFrame> young = torque_statuses(sent_between(-1, 20 * ms));
  ASSERT_FALSE(young.empty());
  for (const CanFrame& frame : young) EXPECT_EQ(state_of(frame), DriveState::torque);
  const std::vector<CanFrame> last = torque_statuses(sent_between(89 * ms, 100 * ms));
  ASSERT_FALSE(last.empty());
  for (const CanFrame& frame : torque_statuses(sent_between(100 * ms, 1'000 * ms))) {
    const TorqueStatus status = decode_torque_status(frame).value();
    EXPECT_EQ(status.state, DriveState::fault);
    EXPECT_TRUE(status.lockout);
    EXPECT_EQ(status.torque, 0.0);
    EXPECT_EQ(status.torque_reference, 0.0);
  }
  EXPECT_EQ(state_of(last.back()), DriveState::fault);
}

TEST_F(TimedOutControlThread, NamesTheWatchdogAndOffersNoTorque) {
  FaultSet watchdog;
  watchdog.set(Fault::watchdog);
  const std::vector<CanFrame> expected{encode(FaultReport{.first = Fault::watchdog, .total = 1}).frame,
                                       encode(ActiveFaults{watchdog}).frame,
                                       encode(LatchedFaults{watchdog}).frame};
  std::map<std::uint32_t, int> faults;
  std::size_t capabilities = 0;
  for (const CanFrame& frame : sent_between(100 * ms, 500 * ms)) {
    const auto found = std::ranges::find(expected, frame.id, &CanFrame::id);
    if (found != expected.end()) {
      ++faults[frame.id];
      EXPECT_EQ(content(frame), content(*found));
    }
    if (frame.id == encode(Capability{}).frame.id) {
      ++capabilities;
      EXPECT_EQ(content(frame), content(encode(Capability{.cause = DeratingCause::gates_are_off}).frame));
    }
  }
  EXPECT_EQ(faults.size(), expected.size());
  for (const auto& [id, count] : faults) EXPECT_GE(count, 3) << std::hex << id;
  EXPECT_GE(capabilities, 3U);
}

TEST_F(TimedOutControlThread, NobodyMeasuresSoThatNoMeasurementIsSent) {
  const auto measured = [](const CanFrame& frame) {
    return frame.id == encode(Motion{}).frame.id || frame.id == encode(Electrical{}).frame.id;
  };
  EXPECT_GT(std::ranges::count_if(sent_between(-1, 20 * ms), measured), 0);
  EXPECT_EQ(std::ranges::count_if(sent_between(100 * ms, 500 * ms), measured), 0);
}

TEST_F(TimedOutControlThread, KeepsTheFaultThatWasThereBefore) {
  Telemetry<double> status;
  status.state = DriveState::fault;
  status.latched.set(Fault::over_current);
  status.first_fault = Fault::over_current;
  status.fault_total = 3;
  shared.status.store(status);
  FaultSet watchdog;
  watchdog.set(Fault::watchdog);
  FaultSet both = status.latched;
  both |= watchdog;
  const std::vector<CanFrame> sent = sent_between(100 * ms, 300 * ms);
  for (const CanFrame& expected : {encode(FaultReport{.first = Fault::over_current, .total = 4}).frame,
                                   encode(ActiveFaults{watchdog}).frame, encode(LatchedFaults{both}).frame}) {
    const auto found = std::ranges::find(sent, expected.id, &CanFrame::id);
    ASSERT_NE(found, sent.end());
    EXPECT_EQ(content(*found), content(expected));
  }
}

// The status frames report the gates off: the gate inhibit makes it so when the control thread runs again.
TEST_F(TimedOutControlThread, GetsTheGateInhibitWithTheReport) {
  (void)sent_between(0, 20 * ms);
  EXPECT_FALSE(shared.gate_inhibit.load());
  (void)sent_between(20 * ms, 100 * ms);
  EXPECT_TRUE(shared.gate_inhibit.load());
}

TEST_F(TimedOutControlThread, ThatIsBackIsBelievedAgain) {
  (void)sent_between(0, 300 * ms);
  shared.heartbeat_ns.store(last_beat_ns + 300 * ms);
  const std::vector<CanFrame> sent = torque_statuses(sent_between(300 * ms, 320 * ms));
  ASSERT_FALSE(sent.empty());
  EXPECT_EQ(state_of(sent.back()), DriveState::torque) << "the drive itself tells what became of it";
}

TEST_F(TimedOutControlThread, HasShutDownWhereItSaidSo) {
  Telemetry<double> status;
  status.state = DriveState::shutdown;
  shared.status.store(status);
  shared.stopped.store(true);
  transmit.send_last(last_beat_ns + 10'000 * ms);
  EXPECT_EQ(state_of(torque_statuses(bus.sent()).back()), DriveState::shutdown);
}

}  // namespace
}  // namespace sextant::ecu
