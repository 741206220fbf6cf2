#include "ecu/threads/receive_thread.hpp"

#include <atomic>
#include <chrono>

#include <gtest/gtest.h>

#include "comms/command_frames.hpp"
#include "ecu/eventually.hpp"
#include "ecu/tasks/control_task.hpp"
#include "ecu/tasks/receive_task.hpp"
#include "ecu/threads/flood_limit.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

/// Has a frame that nobody knows for whoever asks, at once.
class FloodedBus final : public CanBus {
 public:
  [[nodiscard]] CanSend send(const CanFrame&) noexcept override { return CanSend::ok; }
  [[nodiscard]] CanReceive receive(CanFrame& frame, std::chrono::nanoseconds) noexcept override {
    frame = {};
    frame.received_ns = 1;
    ++received_;
    return CanReceive::got;
  }
  [[nodiscard]] CanBusStats stats() const noexcept override { return {}; }
  [[nodiscard]] std::int64_t received() const { return received_.load(); }

 private:
  std::atomic<std::int64_t> received_{0};
};

TEST(FloodLimit, PausesAfterSoManyFramesInARow) {
  FloodLimit limit;
  for (int round = 0; round < 3; ++round) {
    for (int n = 1; n < FloodLimit::most_in_a_row; ++n) EXPECT_FALSE(limit.must_pause(100, 99));
    EXPECT_TRUE(limit.must_pause(100, 99));
  }
}

TEST(FloodLimit, AFrameThatWasWaitedForEndsTheRow) {
  FloodLimit limit;
  for (int n = 1; n < FloodLimit::most_in_a_row; ++n) EXPECT_FALSE(limit.must_pause(100, 99));
  EXPECT_FALSE(limit.must_pause(100, 100));
  EXPECT_FALSE(limit.must_pause(100, 99));
}

// No machine is too slow for it: the bound is from above.
TEST(ReceiveThread, AFloodLeavesTheProcessorToOthers) {
  SharedState shared{25'000, 1};
  FloodedBus bus;
  ReceiveTask task{shared};
  ReceiveThread receive{bus, {&task}, shared.stopped};
  const std::int64_t begin_ns = now_ns();
  receive.start();
  EXPECT_TRUE(test::eventually([&] { return bus.received() > 20 * FloodLimit::most_in_a_row; }));
  shared.stopped.store(true);
  receive.join();
  const std::int64_t pauses = (now_ns() - begin_ns) / FloodLimit::pause_ns;
  EXPECT_LE(bus.received(), (pauses + 1) * FloodLimit::most_in_a_row);
}

CanFrame status_of_another(std::uint8_t counter, std::int64_t received_ns) {
  CanFrame frame = encode(TorqueStatus{.command_counter = {}}).frame;
  sextant::testing::protect(frame, torque_status_data_id(), counter);
  frame.received_ns = received_ns;
  return frame;
}

TEST(ReceiveTask, AnotherDriveIsAFaultForASecondAfterItWasHeard) {
  SharedState shared{25'000, 1};
  ReceiveTask receive{shared};
  SharedCommands commands{shared};
  for (std::uint8_t n = 0; n < 2; ++n) (void)receive.on_frame(status_of_another(n, ns_per_s));
  EXPECT_FALSE(commands.latest(ns_per_s).external.any()) << "two frames may be anybody's";
  EXPECT_FALSE(receive.on_frame(status_of_another(2, ns_per_s)));
  EXPECT_TRUE(commands.latest(ns_per_s).external.test(Fault::second_master));
  EXPECT_TRUE(commands.latest(2 * ns_per_s - 1).external.test(Fault::second_master));
  EXPECT_FALSE(commands.latest(2 * ns_per_s).external.any());
}

}  // namespace
}  // namespace sextant::ecu
