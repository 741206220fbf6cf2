#include "ecu/can_transmit_thread.hpp"

#include <gtest/gtest.h>

#include "ecu/eventually.hpp"
#include "ecu/fake_can_bus.hpp"

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

TEST(CanTransmitThread, TheLastTorqueStatusSaysShutdownWhenEverThatComes) {
  TorqueStatus last{.state = DriveState::shutdown, .command_counter = {}};
  const std::vector<std::uint8_t> expected = content(encode(last).frame);
  for (int run = 0; run < 5; ++run) {
    Crossings crossings{25'000, 40};
    test::FakeCanBus bus;
    CanTransmitThread transmit{bus, crossings};
    Telemetry<double> status;
    status.state = DriveState::torque;
    crossings.status.store(status);
    transmit.start();
    ASSERT_TRUE(test::eventually([&] { return torque_statuses(bus.sent()).size() > std::size_t(run); }));
    status.state = DriveState::shutdown;
    crossings.status.store(status);
    crossings.stopped.store(true);
    transmit.join();
    EXPECT_EQ(content(torque_statuses(bus.sent()).back()), expected) << "run " << run;
  }
}

}  // namespace
}  // namespace sextant::ecu
