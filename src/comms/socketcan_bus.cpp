#include "socketcan_bus.hpp"

#include <algorithm>
#include <cerrno>
#include <stdexcept>

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>

namespace sextant {
namespace {

static_assert(can_error_bus_off == CAN_ERR_BUSOFF);

int open_can_socket() {
  const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (fd >= 0) return fd;
  switch (errno) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
      throw std::runtime_error(
          "this kernel has no CAN sockets (AF_CAN): use a udp_multicast address such as "
          "udp_multicast:239.74.163.2:43113, or load the modules can and can-raw");
    case EPERM:
    case EACCES:
      throw std::runtime_error("a CAN socket may not be opened here: the rights are missing");
    default:
      throw std::runtime_error("a CAN socket cannot be opened: " + error_text(errno));
  }
}

canid_t can_id_of(const CanFrame& frame) noexcept {
  return frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.rtr ? CAN_RTR_FLAG : 0U) |
         (frame.error ? CAN_ERR_FLAG : 0U);
}

/// Data, remote and FD frames of these identifiers.
std::vector<can_filter> filters_for(std::span<const CanIdentifier> wanted) {
  if (wanted.empty()) return {{.can_id = 0, .can_mask = 0}};
  std::vector<can_filter> filters;
  for (const auto [id, extended] : wanted) {
    const canid_t bits = extended ? CAN_EFF_MASK : CAN_SFF_MASK;
    filters.push_back({.can_id = id | (extended ? CAN_EFF_FLAG : 0U), .can_mask = bits | CAN_EFF_FLAG});
  }
  return filters;
}

CanFrame from_kernel(const canfd_frame& in, bool fd) noexcept {
  CanFrame frame;
  frame.error = (in.can_id & CAN_ERR_FLAG) != 0;
  frame.extended = (in.can_id & CAN_EFF_FLAG) != 0 && !frame.error;
  frame.rtr = (in.can_id & CAN_RTR_FLAG) != 0;
  frame.id = in.can_id & (frame.extended || frame.error ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.fd = fd;
  frame.length = std::min<std::uint8_t>(in.len, fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN);
  if (!frame.rtr) std::copy_n(in.data, frame.length, frame.data.begin());
  return frame;
}

bool means_down(int error) noexcept {
  return error == ENETDOWN || error == ENODEV || error == ENXIO;
}

}  // namespace

SocketCanBus::SocketCanBus(const std::string& interface, std::span<const CanIdentifier> wanted)
    : interface_(interface), filters_(filters_for(wanted)), socket_(open_can_socket()) {
  if (interface.empty() || interface.size() >= IFNAMSIZ || if_nametoindex(interface.c_str()) == 0) {
    throw std::runtime_error("there is no network interface \"" + interface +
                             "\": \"ip link show type can\" and \"ip link show type vcan\" list the CAN "
                             "interfaces, \"ip link add dev vcan0 type vcan\" makes a virtual one");
  }
  configure();
  if (!bind_interface()) {
    const std::string reason = errno == ENODEV ? "it is no CAN interface" : error_text(errno);
    throw std::runtime_error("the interface \"" + interface + "\" cannot be used for CAN: " + reason);
  }
  if (!is_up()) {
    throw std::runtime_error("the CAN interface \"" + interface + "\" is down: \"ip link set " + interface +
                             " up\" (a real one needs its bitrate first)");
  }
}

void SocketCanBus::configure() const {
  const bool good = socket_.set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, CAN_ERR_MASK) &&
                    socket_.set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1) &&
                    socket_.set(SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 0) &&
                    socket_.set(SOL_SOCKET, SO_RXQ_OVFL, 1) && socket_.set(SOL_SOCKET, SO_TIMESTAMPNS, 1);
  if (!good) throw std::runtime_error("the CAN socket cannot be configured: " + error_text(errno));
}

bool SocketCanBus::bind_interface() const noexcept {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(interface_.c_str()));
  if (address.can_ifindex == 0) return false;  // index 0 would mean every interface
  // An interface that is removed takes the socket's filters with it.
  const auto size = static_cast<socklen_t>(filters_.size() * sizeof(can_filter));
  if (setsockopt(socket_.fd(), SOL_CAN_RAW, CAN_RAW_FILTER, filters_.data(), size) != 0) return false;
  return bind(socket_.fd(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

bool SocketCanBus::is_up() const noexcept {
  ifreq request{};
  interface_.copy(request.ifr_name, IFNAMSIZ - 1);
  return ioctl(socket_.fd(), SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
}

CanSend SocketCanBus::send(const CanFrame& frame) noexcept {
  canfd_frame out{};
  out.can_id = can_id_of(frame);
  out.len = std::min<std::uint8_t>(frame.length, frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN);
  std::copy_n(frame.data.begin(), out.len, out.data);
  const std::size_t size = frame.fd ? CANFD_MTU : CAN_MTU;
  const ssize_t n = ::send(socket_.fd(), &out, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  return counters_.on_sent(n, size, means_down);
}

CanReceive SocketCanBus::receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept {
  if (down_) try_to_reopen();
  canfd_frame in{};
  Reception r = receiver_.read(socket_.fd(), std::as_writable_bytes(std::span(&in, 1)));
  if (r.length < 0 && r.error == EAGAIN && timeout.count() > 0) {
    if (receiver_.wait(socket_.fd(), timeout) == 0) return down_ ? CanReceive::down : CanReceive::timeout;
    r = receiver_.read(socket_.fd(), std::as_writable_bytes(std::span(&in, 1)));
  }
  if (r.length < 0) return on_receive_error(r.error);
  if (r.has_overflow) counters_.on_overflow_total(r.overflow);
  if (r.length != CAN_MTU && r.length != CANFD_MTU) return CanReceive::error;
  frame = from_kernel(in, r.length == CANFD_MTU);
  frame.received_ns = r.received_ns;
  counters_.on_received(frame);
  return CanReceive::got;
}

CanReceive SocketCanBus::on_receive_error(int error) noexcept {
  if (means_down(error)) down_ = true;
  if (down_) return CanReceive::down;
  return error == EAGAIN || error == EINTR ? CanReceive::timeout : CanReceive::error;
}

void SocketCanBus::try_to_reopen() noexcept {
  // Binding again is what a removed interface needs when it comes back; for one that only went down it
  // changes nothing. The descriptor stays, so the sending thread is not disturbed.
  if (!is_up() || !bind_interface()) return;
  down_ = false;
  counters_.reopened.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace sextant
