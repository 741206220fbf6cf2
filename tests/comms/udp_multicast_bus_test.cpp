#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sextant/comms/can_bus.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

using namespace std::chrono_literals;

/// Buses on a group and port of this process's own.
class UdpMulticastBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      first_ = make_can_bus(address());
      second_ = make_can_bus(address());
    } catch (const std::runtime_error& e) {
      if (std::string(e.what()).find("has no route") == std::string::npos) throw;
      GTEST_SKIP() << "NO MULTICAST ROUTE ON THIS MACHINE: " << e.what();
    }
  }

  [[nodiscard]] static int port() { return 20000 + static_cast<int>(getpid()) % 20000; }
  [[nodiscard]] static std::string address() {
    return "udp_multicast:239.74.163.7:" + std::to_string(port());
  }

  /// Sends raw bytes to the group.
  static void send_raw(std::string_view bytes) {
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port()));
    inet_pton(AF_INET, "239.74.163.7", &to.sin_addr);
    sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
    close(fd);
  }

  std::unique_ptr<CanBus> first_;
  std::unique_ptr<CanBus> second_;
};

TEST_F(UdpMulticastBusTest, CarriesFramesBothWaysInOrder) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const CanFrame out{.id = i, .extended = i % 2 == 1, .length = static_cast<std::uint8_t>(i % 9)};
    ASSERT_EQ((i < 50 ? first_ : second_)->send(out), CanSend::ok);
    CanFrame in;
    ASSERT_EQ((i < 50 ? second_ : first_)->receive(in, 1s), CanReceive::got);
    EXPECT_EQ(in.id, out.id);
    EXPECT_EQ(in.extended, out.extended);
    EXPECT_EQ(in.length, out.length);
  }
  EXPECT_EQ(first_->stats().sent, 50U);
  EXPECT_EQ(first_->stats().received, 50U);
}

TEST_F(UdpMulticastBusTest, DoesNotReceiveItsOwnFrames) {
  ASSERT_EQ(first_->send({.id = 0x120, .length = 8}), CanSend::ok);
  CanFrame in;
  ASSERT_EQ(second_->receive(in, 1s), CanReceive::got);  // by now the loopback has been delivered
  EXPECT_EQ(first_->receive(in, 0s), CanReceive::timeout);
}

TEST_F(UdpMulticastBusTest, StampsTheArrivalOnTheMonotonicClock) {
  std::this_thread::sleep_for(100ms);  // the kernel switches its stamps on some time after it was asked
  const std::int64_t before = now_ns();
  ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
  std::this_thread::sleep_for(50ms);
  const std::int64_t reading = now_ns();
  CanFrame in;
  ASSERT_EQ(second_->receive(in, 1s), CanReceive::got);
  EXPECT_GE(in.received_ns, before);
  EXPECT_LT(in.received_ns, reading);  // the arrival, not the reading
}

TEST_F(UdpMulticastBusTest, CountsUnreadableDatagramsAndGoesOn) {
  send_raw("");
  send_raw(
      "\x81\xa3"
      "dlc");
  send_raw(std::string(3000, '\x90'));
  ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
  CanFrame in;
  ASSERT_EQ(second_->receive(in, 1s), CanReceive::got);
  EXPECT_EQ(in.id, 0x110U);
  EXPECT_EQ(second_->stats().receive_malformed, 3U);
}

// More than are read at once: the frame behind them must come with the same call, not after a pause.
TEST_F(UdpMulticastBusTest, AFrameBehindManyUnreadableDatagramsComesAtOnce) {
  constexpr unsigned unreadable = 100;
  for (unsigned i = 0; i < unreadable; ++i) send_raw("?");
  ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
  CanFrame in;
  ASSERT_EQ(second_->receive(in, 1s), CanReceive::got);
  EXPECT_EQ(in.id, 0x110U);
  EXPECT_EQ(second_->stats().receive_malformed, unreadable);
}

TEST_F(UdpMulticastBusTest, CountsWhatTheSocketDropped) {
  constexpr unsigned flood = 5000;
  unsigned sent = 0;
  for (unsigned i = 0; i < flood; ++i)
    sent += first_->send({.id = i & 0x7FFU, .length = 8}) == CanSend::ok ? 1U : 0U;
  ASSERT_EQ(first_->stats().sent, sent);
  ASSERT_EQ(first_->stats().send_dropped, flood - sent);
  CanFrame in;
  unsigned received = 0;
  while (second_->receive(in, 50ms) == CanReceive::got) ++received;
  ASSERT_LT(received, sent);
  // The kernel tells of its drops with the next frame that it queues.
  ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
  ASSERT_EQ(second_->receive(in, 1s), CanReceive::got);
  EXPECT_EQ(second_->stats().receive_overflow, sent - received);
}

TEST_F(UdpMulticastBusTest, TimesOut) {
  CanFrame in;
  EXPECT_EQ(first_->receive(in, 0s), CanReceive::timeout);
  EXPECT_EQ(first_->receive(in, 5ms), CanReceive::timeout);
}

}  // namespace
}  // namespace sextant
