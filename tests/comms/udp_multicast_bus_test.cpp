#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "sextant/comms/can_bus.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

using namespace std::chrono_literals;

constexpr auto patience = 60s;  // for a frame that is on its way

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
    ASSERT_EQ((i < 50 ? second_ : first_)->receive(in, patience), CanReceive::got);
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
  ASSERT_EQ(second_->receive(in, patience), CanReceive::got);  // by now the loopback has been delivered
  EXPECT_EQ(first_->receive(in, 0s), CanReceive::timeout);
}

TEST_F(UdpMulticastBusTest, StampsTheArrivalOnTheMonotonicClock) {
  // The kernel switches its stamps on some time after it was asked; until then it is the reading.
  bool is_arrival = false;
  for (const std::int64_t begin_ns = now_ns(); !is_arrival && now_ns() - begin_ns < 60 * ns_per_s;) {
    const std::int64_t before_ns = now_ns();
    ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
    std::this_thread::sleep_for(50ms);
    const std::int64_t reading_ns = now_ns();
    CanFrame in;
    ASSERT_EQ(second_->receive(in, patience), CanReceive::got);
    EXPECT_GE(in.received_ns, before_ns);
    is_arrival = in.received_ns < reading_ns;
  }
  EXPECT_TRUE(is_arrival);
}

TEST_F(UdpMulticastBusTest, CountsUnreadableDatagramsAndGoesOn) {
  send_raw("");
  send_raw(
      "\x81\xa3"
      "dlc");
  send_raw(std::string(3000, '\x90'));
  ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
  CanFrame in;
  ASSERT_EQ(second_->receive(in, patience), CanReceive::got);
  EXPECT_EQ(in.id, 0x110U);
  EXPECT_EQ(second_->stats().receive_malformed, 3U);
}

// More than are read at once: the frame behind them must come with the same call, not after a pause.
TEST_F(UdpMulticastBusTest, AFrameBehindManyUnreadableDatagramsComesAtOnce) {
  constexpr unsigned unreadable = 100;
  for (unsigned i = 0; i < unreadable; ++i) send_raw("?");
  ASSERT_EQ(first_->send({.id = 0x110, .length = 8}), CanSend::ok);
  CanFrame in;
  ASSERT_EQ(second_->receive(in, patience), CanReceive::got);
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
  ASSERT_EQ(second_->receive(in, patience), CanReceive::got);
  EXPECT_EQ(second_->stats().receive_overflow, sent - received);
}

TEST_F(UdpMulticastBusTest, OnlyWantedIdentifiersAreReceived) {
  const CanIdentifier wanted[] = {{.id = 0x110}, {.id = 0x120, .extended = true}};
  const auto bus = make_can_bus(address(), wanted);
  const auto send = [this](const CanFrame& frame) { ASSERT_EQ(first_->send(frame), CanSend::ok); };
  for (std::uint32_t i = 0; i < 40; ++i) send({.id = 0x200 + i, .length = 8});
  send({.id = 0x110, .length = 8});
  send({.id = 0x110, .extended = true, .length = 8});
  send({.id = 0x120, .length = 8});
  send({.id = 0x120, .extended = true, .length = 8});
  send({.id = 0x110, .rtr = true, .length = 8});
  send({.id = can_error_bus_off, .error = true, .length = 8});
  for (const std::uint32_t id : {0x110U, 0x120U, 0x110U, can_error_bus_off}) {
    CanFrame in;
    ASSERT_EQ(bus->receive(in, 10s), CanReceive::got);
    EXPECT_EQ(in.id, id);
  }
  CanFrame in;
  EXPECT_EQ(bus->receive(in, 0s), CanReceive::timeout);
  EXPECT_EQ(bus->stats().received, 4U);
}

/// Runs `body` in a network of its own, with an interface that has the default route, while multicast is
/// routed to lo; false where this may not be made.
bool with_multicast_on_loopback(const std::function<void()>& body) {
  bool made = false;
  std::thread{[&] {
    // A new network belongs to this thread and to the commands that it starts.
    made = unshare(CLONE_NEWNET) == 0 &&
           std::system(
               "(ip link set lo up && ip link add v0 type veth peer name v1 && ip link set v0 up && "
               "ip link set v1 up && ip addr add 10.9.8.7/24 dev v0 && "
               "ip route add default via 10.9.8.1 && ip route add 239.0.0.0/8 dev lo) 2>/dev/null") == 0;
    if (made) body();
  }}.join();
  return made;
}

/// What another program of this machine gets that joins the group without naming an interface.
int open_listener(const sockaddr_in& group) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  const int yes = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  setsockopt(fd, SOL_SOCKET, SO_REUSEPORT, &yes, sizeof(yes));
  const timeval longest{.tv_sec = 5, .tv_usec = 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof(longest));
  ip_mreq membership{};
  membership.imr_multiaddr = group.sin_addr;
  EXPECT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&group), sizeof(group)), 0);
  EXPECT_EQ(setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)), 0);
  return fd;
}

TEST(UdpMulticastRoute, OverLoopbackBesideADefaultRouteIsFollowed) {
  const bool tried = with_multicast_on_loopback([] {
    sockaddr_in group{};
    group.sin_family = AF_INET;
    group.sin_port = htons(43113);
    inet_pton(AF_INET, "239.74.163.2", &group.sin_addr);
    const int listener = open_listener(group);
    const auto bus = make_can_bus("udp_multicast:239.74.163.2:43113");
    const auto other = make_can_bus("udp_multicast:239.74.163.2:43113");
    ASSERT_EQ(bus->send({.id = 0x120, .length = 8}), CanSend::ok);
    char buffer[512];
    EXPECT_GT(recv(listener, buffer, sizeof(buffer), 0), 0) << "an unbound socket follows the routes";
    CanFrame in;
    EXPECT_EQ(other->receive(in, 5s), CanReceive::got);
    // And the other way round: as python-can sends.
    ASSERT_GT(sendto(listener, "x", 1, 0, reinterpret_cast<const sockaddr*>(&group), sizeof(group)), 0);
    (void)bus->receive(in, 100ms);
    EXPECT_EQ(bus->stats().receive_malformed, 1U);
    EXPECT_EQ(bus->trouble(), "");
    close(listener);
  });
  if (!tried) GTEST_SKIP() << "NO RIGHT TO MAKE A NETWORK HERE";
}

/// Sends until so many more frames have left; a queue of the kernel's that is full refuses some.
void send_frames(CanBus& bus, std::uint64_t count) {
  const std::uint64_t goal = bus.stats().sent + count;
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (bus.stats().sent < goal && std::chrono::steady_clock::now() < deadline) {
    if (bus.send({.id = 0x120, .length = 8}) != CanSend::ok) std::this_thread::sleep_for(1ms);
  }
  ASSERT_GE(bus.stats().sent, goal);
}

TEST_F(UdpMulticastBusTest, ABusThatNeverHearsItselfSaysSo) {
  CanFrame in;
  send_frames(*first_, 20);
  (void)first_->receive(in, 0s);
  send_frames(*first_, 2000);
  EXPECT_EQ(first_->trouble(), "");
  EXPECT_EQ(second_->trouble(), "") << "it has sent nothing";
  send_frames(*second_, 2000);
  EXPECT_NE(second_->trouble().find("none came back"), std::string::npos) << "it was never asked to receive";
}

TEST_F(UdpMulticastBusTest, TimesOut) {
  CanFrame in;
  EXPECT_EQ(first_->receive(in, 0s), CanReceive::timeout);
  EXPECT_EQ(first_->receive(in, 5ms), CanReceive::timeout);
}

}  // namespace
}  // namespace sextant
