#include <chrono>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/command_frames.hpp"
#include "comms/refusal.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/can_codec.hpp"
#include "sextant/comms/command_receiver.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

using namespace std::chrono_literals;
using testing::command_frame;
using testing::refusal;

void run(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

constexpr auto patience = 60s;  // for a frame that is on its way

class SocketCanBusTest : public ::testing::Test {
 protected:
  void TearDown() override { run("ip link set vcan0 up"); }

  std::unique_ptr<CanBus> drive_{make_can_bus("socketcan:vcan0")};
  std::unique_ptr<CanBus> vehicle_{make_can_bus("socketcan:vcan0")};
};

TEST_F(SocketCanBusTest, CarriesEveryKindOfFrame) {
  CanFrame frames[] = {{.id = 0x7FF, .length = 8},
                       {.id = 0x1FFFFFFF, .extended = true, .length = 3},
                       {.id = 0x110, .rtr = true, .length = 8},
                       {.id = 0x110, .fd = true, .length = 64},
                       {.id = can_error_bus_off, .error = true, .length = 8},
                       {.id = 0x110, .length = 0}};
  for (CanFrame& out : frames) {
    for (std::uint8_t i = 0; i < out.length && !out.rtr; ++i) out.data[i] = static_cast<std::uint8_t>(i + 1);
    ASSERT_EQ(vehicle_->send(out), CanSend::ok);
    CanFrame in;
    ASSERT_EQ(drive_->receive(in, patience), CanReceive::got);
    EXPECT_EQ(in.id, out.id);
    EXPECT_EQ(in.extended, out.extended);
    EXPECT_EQ(in.rtr, out.rtr);
    EXPECT_EQ(in.error, out.error);
    EXPECT_EQ(in.fd, out.fd);
    EXPECT_EQ(in.length, out.length);
    EXPECT_EQ(in.data, out.data);
  }
  EXPECT_EQ(drive_->stats().error_frames, 1U);
  EXPECT_EQ(drive_->stats().bus_off, 1U);
}

TEST_F(SocketCanBusTest, CarriesAThousandFramesInOrderWithoutItsOwn) {
  for (std::uint32_t i = 0; i < 1000; ++i) {
    ASSERT_EQ(vehicle_->send({.id = i, .length = 8}), CanSend::ok);
    ASSERT_EQ(drive_->send({.id = 0x120, .length = 8}), CanSend::ok);
    CanFrame in;
    ASSERT_EQ(drive_->receive(in, patience), CanReceive::got);
    EXPECT_EQ(in.id, i);
    ASSERT_EQ(vehicle_->receive(in, patience), CanReceive::got);
    EXPECT_EQ(in.id, 0x120U);
  }
  CanFrame in;
  EXPECT_EQ(drive_->receive(in, 0s), CanReceive::timeout);
  EXPECT_EQ(drive_->stats().receive_overflow, 0U);
}

TEST_F(SocketCanBusTest, CommandsPassAndAliasesAreRefusedByTheReceiver) {
  CommandReceiver receiver;
  const auto pass = [&](const CanFrame& frame) {
    EXPECT_EQ(vehicle_->send(frame), CanSend::ok);
    CanFrame in;
    EXPECT_EQ(drive_->receive(in, patience), CanReceive::got);
    return receiver.on_frame(in);
  };
  for (std::uint8_t i = 0; i < 3; ++i) pass(command_frame(i, 5.0));
  EXPECT_EQ(pass(command_frame(3, 6.0)), FrameVerdict::accepted);
  CanFrame fd = command_frame(4, 7.0);
  fd.fd = true;
  EXPECT_EQ(pass(fd), FrameVerdict::fd_alias);
  CanFrame extended = command_frame(4, 7.0);
  extended.extended = true;
  EXPECT_EQ(pass(extended), FrameVerdict::extended_alias);
  CanFrame remote = command_frame(4, 7.0);
  remote.rtr = true;
  EXPECT_EQ(pass(remote), FrameVerdict::remote_frame);
  EXPECT_EQ(pass({.id = can_error_bus_off, .error = true, .length = 8}), FrameVerdict::error_frame);
  EXPECT_TRUE(receiver.command().bus_off);
  EXPECT_NEAR(receiver.command().torque, 6.0, 1e-9);
}

class SocketCanFilterTest : public SocketCanBusTest, public ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Offsets, SocketCanFilterTest, ::testing::Values(0, 64, 1728));

TEST_P(SocketCanFilterTest, ADriveReceivesNothingButWhatItNeeds) {
  const IdentifierOffset offset{GetParam()};
  const auto bus = make_can_bus("socketcan:vcan0", drive_identifiers(offset));
  constexpr unsigned foreign = 5000;
  unsigned sent = 0;
  for (std::uint32_t i = 0; sent < foreign; ++i) {
    const CanFrame frame{.id = i % 0x800, .extended = i % 3 == 0, .fd = i % 5 == 0, .length = 8};
    const bool needed = frame.id == offset.id(0x110) || (frame.id == offset.id(0x120) && !frame.extended);
    if (needed) continue;
    ASSERT_EQ(vehicle_->send(frame), CanSend::ok);
    ++sent;
  }
  CanFrame frames[] = {{.id = offset.id(0x110), .length = 8},
                       {.id = offset.id(0x110), .extended = true, .length = 8},
                       {.id = offset.id(0x110), .rtr = true, .length = 8},
                       {.id = offset.id(0x110), .fd = true, .length = 8},
                       {.id = offset.id(0x110), .length = 0},
                       {.id = offset.id(0x120), .length = 8},
                       {.id = can_error_bus_off, .error = true, .length = 8}};
  for (const CanFrame& frame : frames) ASSERT_EQ(vehicle_->send(frame), CanSend::ok);
  for (const CanFrame& out : frames) {
    CanFrame in;
    ASSERT_EQ(bus->receive(in, 10s), CanReceive::got);
    EXPECT_EQ(in.id, out.id);
    EXPECT_EQ(in.extended, out.extended);
    EXPECT_EQ(in.rtr, out.rtr);
    EXPECT_EQ(in.fd, out.fd);
    EXPECT_EQ(in.error, out.error);
  }
  CanFrame in;
  EXPECT_EQ(bus->receive(in, 0s), CanReceive::timeout);
  EXPECT_EQ(bus->stats().received, std::size(frames));
  EXPECT_EQ(bus->stats().receive_overflow, 0U) << "the kernel has queued no foreign frame either";
}

TEST_F(SocketCanBusTest, KeepsItsFilterWhenTheInterfaceComesBack) {
  run("ip link add dev vcan7 type vcan && ip link set vcan7 up");
  const auto bus = make_can_bus("socketcan:vcan7", drive_identifiers());
  run("ip link del vcan7");
  CanFrame in;
  EXPECT_EQ(bus->receive(in, 10ms), CanReceive::down);
  run("ip link add dev vcan7 type vcan && ip link set vcan7 up");
  EXPECT_EQ(bus->receive(in, 10ms), CanReceive::timeout);
  const auto other = make_can_bus("socketcan:vcan7");
  ASSERT_EQ(other->send({.id = 0x200, .length = 8}), CanSend::ok);
  ASSERT_EQ(other->send({.id = 0x110, .length = 8}), CanSend::ok);
  ASSERT_EQ(bus->receive(in, 10s), CanReceive::got);
  EXPECT_EQ(in.id, 0x110U);
  run("ip link del vcan7");
}

TEST_F(SocketCanBusTest, StampsTheArrivalOnTheMonotonicClock) {
  // The kernel switches its stamps on some time after it was asked; until then it is the reading.
  bool is_arrival = false;
  for (const std::int64_t begin_ns = now_ns(); !is_arrival && now_ns() - begin_ns < 60 * ns_per_s;) {
    const std::int64_t before_ns = now_ns();
    ASSERT_EQ(vehicle_->send({.id = 0x110, .length = 8}), CanSend::ok);
    std::this_thread::sleep_for(50ms);
    const std::int64_t reading_ns = now_ns();
    CanFrame in;
    ASSERT_EQ(drive_->receive(in, patience), CanReceive::got);
    EXPECT_GE(in.received_ns, before_ns);
    is_arrival = in.received_ns < reading_ns;
  }
  EXPECT_TRUE(is_arrival);
}

TEST_F(SocketCanBusTest, CountsWhatTheSocketDropped) {
  constexpr unsigned flood = 3000;
  for (unsigned i = 0; i < flood; ++i)
    ASSERT_EQ(vehicle_->send({.id = i & 0x7FFU, .length = 8}), CanSend::ok);
  CanFrame in;
  unsigned received = 0;
  while (drive_->receive(in, 50ms) == CanReceive::got) ++received;
  ASSERT_LT(received, flood);
  ASSERT_EQ(vehicle_->send({.id = 0x110, .length = 8}), CanSend::ok);
  ASSERT_EQ(drive_->receive(in, patience), CanReceive::got);
  EXPECT_EQ(drive_->stats().receive_overflow, flood - received);
}

TEST_F(SocketCanBusTest, ComesBackAfterTheInterfaceWentDown) {
  run("ip link set vcan0 down");
  CanFrame in;
  EXPECT_EQ(drive_->receive(in, 10ms), CanReceive::down);
  EXPECT_EQ(drive_->receive(in, 10ms), CanReceive::down);
  EXPECT_EQ(drive_->send({.id = 0x120, .length = 8}), CanSend::down);
  EXPECT_EQ(drive_->stats().send_dropped, 1U);
  run("ip link set vcan0 up");
  EXPECT_EQ(drive_->receive(in, 10ms), CanReceive::timeout);
  EXPECT_EQ(drive_->stats().reopened, 1U);
  ASSERT_EQ(drive_->send({.id = 0x120, .length = 8}), CanSend::ok);
  (void)vehicle_->receive(in, 10ms);  // its own report of the interruption
  ASSERT_EQ(vehicle_->send({.id = 0x110, .length = 8}), CanSend::ok);
  ASSERT_EQ(drive_->receive(in, patience), CanReceive::got);
  EXPECT_EQ(in.id, 0x110U);
}

TEST_F(SocketCanBusTest, ComesBackAfterTheInterfaceWasRemoved) {
  run("ip link add dev vcan7 type vcan && ip link set vcan7 up");
  const auto bus = make_can_bus("socketcan:vcan7");
  run("ip link del vcan7");
  CanFrame in;
  EXPECT_EQ(bus->receive(in, 10ms), CanReceive::down);
  EXPECT_EQ(bus->send({.id = 0x120, .length = 8}), CanSend::down);
  EXPECT_EQ(bus->receive(in, 10ms), CanReceive::down);
  run("ip link add dev vcan7 type vcan && ip link set vcan7 up");
  EXPECT_EQ(bus->receive(in, 10ms), CanReceive::timeout);
  const auto other = make_can_bus("socketcan:vcan7");
  ASSERT_EQ(other->send({.id = 0x110, .length = 8}), CanSend::ok);
  EXPECT_EQ(bus->receive(in, patience), CanReceive::got);
  run("ip link del vcan7");
}

TEST_F(SocketCanBusTest, DropsAndCountsWhenTheQueueIsFull) {
  // A token bucket of one frame a second makes the queue that vcan lacks.
  run("ip link add dev vcan8 type vcan && ip link set vcan8 up");
  if (std::system("tc qdisc add dev vcan8 root tbf rate 128bit burst 16 limit 64 2>/dev/null") != 0) {
    run("ip link del vcan8");
    GTEST_SKIP() << "THIS KERNEL HAS NO tbf QUEUE DISCIPLINE";
  }
  const auto bus = make_can_bus("socketcan:vcan8");
  CanSend last = CanSend::ok;
  for (int i = 0; i < 100 && last == CanSend::ok; ++i) last = bus->send({.id = 0x120, .length = 8});
  EXPECT_EQ(last, CanSend::no_buffer);
  EXPECT_EQ(bus->stats().send_dropped, 1U);
  run("ip link del vcan8");
}

TEST_F(SocketCanBusTest, RefusesUnknownDownAndForeignInterfacesWithASentence) {
  EXPECT_THAT(refusal("socketcan:no_such_can"),
              ::testing::HasSubstr("there is no network interface \"no_such_can\""));
  EXPECT_THAT(refusal("socketcan:"), ::testing::HasSubstr("there is no network interface \"\""));
  EXPECT_THAT(refusal("socketcan:a_name_much_too_long_for_linux"),
              ::testing::HasSubstr("no network interface"));
  EXPECT_THAT(refusal("socketcan:lo"), ::testing::HasSubstr("it is no CAN interface"));
  run("ip link set vcan0 down");
  EXPECT_THAT(refusal("socketcan:vcan0"), ::testing::HasSubstr("\"ip link set vcan0 up\""));
}

}  // namespace
}  // namespace sextant
