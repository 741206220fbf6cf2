#include "socket.hpp"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>

#include <poll.h>
#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

std::int64_t to_ns(const timespec& t) noexcept {
  return std::int64_t{t.tv_sec} * ns_per_s + t.tv_nsec;
}

/// Time since the kernel's stamp, by the wall clock. [ns]
std::int64_t age_ns(const timespec& stamp) noexcept {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  return to_ns(wall) - to_ns(stamp);
}

template <class T>
T content(const cmsghdr& header) noexcept {
  T value{};
  std::memcpy(&value, CMSG_DATA(&header), sizeof(value));
  return value;
}

}  // namespace

std::string error_text(int error) {
  return std::system_category().message(error);
}

Socket::~Socket() {
  if (fd_ >= 0) close(fd_);
}

bool Socket::set(int level, int option, int value) const noexcept {
  return setsockopt(fd_, level, option, &value, sizeof(value)) == 0;
}

int Receiver::wait(int fd, std::chrono::nanoseconds timeout) noexcept {
  pollfd p{.fd = fd, .events = POLLIN, .revents = 0};
  const timespec t{.tv_sec = static_cast<time_t>(timeout.count() / ns_per_s),
                   .tv_nsec = static_cast<long>(timeout.count() % ns_per_s)};
  const std::int64_t before = now_ns();
  const int ready = ppoll(&p, 1, &t, nullptr);
  if (ready == 0) empty_ns_ = before;
  return ready;
}

Reception Receiver::read(int fd, std::span<std::byte> buffer) noexcept {
  Reception r;
  iovec part{.iov_base = buffer.data(), .iov_len = buffer.size()};
  alignas(cmsghdr) std::byte control[CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t))];
  msghdr message{};
  message.msg_name = &r.sender;
  message.msg_namelen = sizeof(r.sender);
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);

  const std::int64_t before = now_ns();
  r.length = recvmsg(fd, &message, MSG_DONTWAIT);
  if (r.length < 0) {
    r.error = errno;
    if (r.error == EAGAIN) empty_ns_ = before;
    return r;
  }
  r.flags = message.msg_flags;
  r.received_ns = now_ns();
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_TIMESTAMPNS) {
      const std::int64_t age = age_ns(content<timespec>(*c));
      const std::int64_t arrival = now_ns() - age;  // in this order it errs late, by one reading of a clock
      if (arrival >= empty_ns_ && arrival < r.received_ns) r.received_ns = arrival;
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      r.has_overflow = true;
      r.overflow = content<std::uint32_t>(*c);
    }
  }
  return r;
}

}  // namespace sextant
