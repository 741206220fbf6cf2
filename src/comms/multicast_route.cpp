#include "multicast_route.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include "socket.hpp"

namespace sextant {
namespace {

/// RTM_GETROUTE with one attribute, the destination.
struct RouteRequest {
  nlmsghdr header{};
  rtmsg route{};
  rtattr attribute{};
  in_addr destination{};
};

RouteRequest request_for(in_addr group) noexcept {
  RouteRequest request;
  request.header.nlmsg_len = sizeof(request);
  request.header.nlmsg_type = RTM_GETROUTE;
  request.header.nlmsg_flags = NLM_F_REQUEST;
  request.route.rtm_family = AF_INET;
  request.route.rtm_dst_len = 32;
  request.attribute.rta_type = RTA_DST;
  request.attribute.rta_len = sizeof(request.attribute) + sizeof(request.destination);
  request.destination = group;
  return request;
}

/// The object at `offset` of a message; zeros where the message ends before.
template <class T>
T content(std::span<const std::byte> message, std::size_t offset) noexcept {
  T value{};
  if (offset + sizeof(value) <= message.size()) std::memcpy(&value, &message[offset], sizeof(value));
  return value;
}

constexpr std::size_t aligned(std::size_t length) noexcept {
  return (length + NLMSG_ALIGNTO - 1) / NLMSG_ALIGNTO * NLMSG_ALIGNTO;
}

/// RTA_OIF of the kernel's answer; 0 with errno.
int interface_of(std::span<const std::byte> answer) noexcept {
  constexpr std::size_t begin = aligned(sizeof(nlmsghdr));
  if (content<nlmsghdr>(answer, 0).nlmsg_type == NLMSG_ERROR) {
    errno = -content<nlmsgerr>(answer, begin).error;
    return 0;
  }
  std::size_t at = begin + aligned(sizeof(rtmsg));
  while (at + sizeof(rtattr) <= answer.size()) {
    const auto attribute = content<rtattr>(answer, at);
    if (attribute.rta_type == RTA_OIF) return content<int>(answer, at + aligned(sizeof(rtattr)));
    at += aligned(std::max<std::size_t>(attribute.rta_len, sizeof(rtattr)));
  }
  errno = ENODATA;
  return 0;
}

}  // namespace

int outgoing_interface(in_addr group) noexcept {
  const Socket kernel{socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
  const RouteRequest request = request_for(group);
  if (kernel.fd() < 0 || send(kernel.fd(), &request, sizeof(request), 0) != ssize_t{sizeof(request)})
    return 0;
  std::array<std::byte, 4096> buffer{};
  const ssize_t length = recv(kernel.fd(), buffer.data(), buffer.size(), 0);
  return length > 0 ? interface_of(std::span(buffer).first(static_cast<std::size_t>(length))) : 0;
}

}  // namespace sextant
