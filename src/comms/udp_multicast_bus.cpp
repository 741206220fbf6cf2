#include "udp_multicast_bus.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <thread>

#include <arpa/inet.h>
#include <net/if.h>

#include "can_datagram.hpp"
#include "multicast_route.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

constexpr std::size_t largest_datagram = 4096;

int open_udp_socket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) throw std::runtime_error("a UDP socket cannot be opened: " + error_text(errno));
  return fd;
}

sockaddr_in group_address(const std::string& group, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  if (inet_pton(AF_INET, group.c_str(), &address.sin_addr) != 1 ||
      !IN_MULTICAST(ntohl(address.sin_addr.s_addr))) {
    throw std::runtime_error("\"" + group +
                             "\" is no IPv4 multicast group (224.0.0.0 to 239.255.255.255), such as "
                             "239.74.163.2");
  }
  return address;
}

/// What bind, connect and recvmsg take.
const sockaddr* generic(const sockaddr_in& address) noexcept {
  return reinterpret_cast<const sockaddr*>(&address);
}

bool means_unreachable(int error) noexcept {
  return error == ENETDOWN || error == ENETUNREACH || error == ENODEV || error == EADDRNOTAVAIL;
}

double wall_clock_s() noexcept {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

UdpMulticastBus::UdpMulticastBus(const std::string& group, std::uint16_t port,
                                 std::span<const CanIdentifier> wanted)
    : name_("udp_multicast:" + group + ":" + std::to_string(port)),
      wanted_(wanted.begin(), wanted.end()),
      sending_(open_udp_socket()),
      receiving_(open_udp_socket()) {
  const sockaddr_in address = group_address(group, port);
  interface_ = outgoing_interface(address.sin_addr);
  open_sender(address);
  open_receiver(address);
}

void UdpMulticastBus::open_sender(const sockaddr_in& group) {
  // A connected socket has a source address, and the kernel sends by the interface of that address instead of
  // the routes: beside a default route not over lo, so that receivers that follow the routes get nothing.
  ip_mreqn leaving{};
  leaving.imr_ifindex = interface_;
  const bool configured =
      sending_.set(IPPROTO_IP, IP_MULTICAST_TTL, 1) && sending_.set(IPPROTO_IP, IP_MULTICAST_LOOP, 1) &&
      (interface_ == 0 ||
       setsockopt(sending_.fd(), IPPROTO_IP, IP_MULTICAST_IF, &leaving, sizeof(leaving)) == 0);
  socklen_t length = sizeof(own_);
  if (configured && connect(sending_.fd(), generic(group), sizeof(group)) == 0 &&
      getsockname(sending_.fd(), reinterpret_cast<sockaddr*>(&own_), &length) == 0) {
    return;
  }
  if (errno == ENETUNREACH) {
    throw std::runtime_error(name_ + " has no route, so that no frame would come or go: " +
                             "\"ip route add 239.0.0.0/8 dev lo\" makes one within this machine");
  }
  throw std::runtime_error(name_ + " cannot be opened for sending: " + error_text(errno));
}

void UdpMulticastBus::open_receiver(const sockaddr_in& group) {
  ip_mreqn membership{};
  membership.imr_multiaddr = group.sin_addr;
  membership.imr_ifindex = interface_;
  const bool good =
      receiving_.set(SOL_SOCKET, SO_REUSEADDR, 1) && receiving_.set(SOL_SOCKET, SO_REUSEPORT, 1) &&
      receiving_.set(SOL_SOCKET, SO_TIMESTAMPNS, 1) && receiving_.set(SOL_SOCKET, SO_RXQ_OVFL, 1) &&
      bind(receiving_.fd(), generic(group), sizeof(group)) == 0 &&
      setsockopt(receiving_.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) == 0;
  if (good) return;
  if (errno == EADDRINUSE) {
    throw std::runtime_error(name_ + " is held by another program that does not share its port");
  }
  throw std::runtime_error(name_ + " cannot be opened for receiving: " + error_text(errno));
}

CanSend UdpMulticastBus::send(const CanFrame& frame) noexcept {
  const CanDatagram datagram = pack_datagram(frame, wall_clock_s());
  const ssize_t n =
      ::send(sending_.fd(), datagram.bytes.data(), datagram.length, MSG_DONTWAIT | MSG_NOSIGNAL);
  return counters_.on_sent(n, datagram.length, means_unreachable);
}

CanReceive UdpMulticastBus::receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept {
  // A flood of other frames must not keep threads of lower priority from the processor.
  constexpr std::chrono::milliseconds pause{1};
  const std::int64_t deadline = now_ns() + timeout.count();
  for (;;) {
    const Look look = read(frame);
    if (look.result != CanReceive::timeout) return look.result;
    const std::int64_t left = deadline - now_ns();
    if (left <= 0) return CanReceive::timeout;
    if (look.more) {
      std::this_thread::sleep_for(pause);
    } else if (receiver_.wait(receiving_.fd(), std::chrono::nanoseconds(left)) <= 0) {
      return CanReceive::timeout;
    }
  }
}

/// Reads until a wanted frame of another sender has come or no frame is left, but a bounded number of other
/// frames at once.
UdpMulticastBus::Look UdpMulticastBus::read(CanFrame& frame) noexcept {
  constexpr int most_skipped = 64;
  std::array<std::byte, largest_datagram> buffer;
  for (int i = 0; i < most_skipped; ++i) {
    const Reception r = receiver_.read(receiving_.fd(), buffer);
    if (r.length < 0) {
      if (r.error == EAGAIN || r.error == EINTR) return {};
      return {means_unreachable(r.error) ? CanReceive::down : CanReceive::error};
    }
    if (take(r, buffer, frame)) return {CanReceive::got};
  }
  return {.more = true};
}

/// True for a wanted frame of another sender.
bool UdpMulticastBus::take(const Reception& reception, std::span<const std::byte> buffer,
                           CanFrame& frame) noexcept {
  if (reception.has_overflow) counters_.on_overflow_total(reception.overflow);
  if (is_own(reception.sender)) {
    received_own_frame_.store(true, std::memory_order_relaxed);
    return false;
  }
  const auto bytes = buffer.first(static_cast<std::size_t>(reception.length));
  const auto received = unpack_datagram({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!received) {
    counters_.receive_malformed.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (!is_wanted(*received)) return false;
  frame = *received;
  frame.received_ns = reception.received_ns;
  counters_.on_received(frame);
  return true;
}

bool UdpMulticastBus::is_wanted(const CanFrame& frame) const noexcept {
  if (wanted_.empty() || frame.error) return true;
  return std::ranges::find(wanted_, CanIdentifier{frame.id, frame.extended}) != wanted_.end();
}

std::string UdpMulticastBus::trouble() const {
  constexpr std::uint64_t plenty = 1000;  // a few seconds of status frames
  if (received_own_frame_.load(std::memory_order_relaxed) || counters_.stats().sent < plenty) return {};
  std::array<char, IF_NAMESIZE> interface{"?"};
  (void)if_indextoname(static_cast<unsigned>(interface_), interface.data());
  return name_ + ": of more than " + std::to_string(plenty) + " frames sent over the interface " +
         interface.data() +
         " none came back, so that no program of this machine receives from the drive: check \"ip route " +
         "get\" for the group, and for a firewall that drops multicast";
}

bool UdpMulticastBus::is_own(const sockaddr_storage& sender) const noexcept {
  sockaddr_in from{};
  std::memcpy(&from, &sender, sizeof(from));
  return from.sin_port == own_.sin_port && from.sin_addr.s_addr == own_.sin_addr.s_addr;
}

}  // namespace sextant
