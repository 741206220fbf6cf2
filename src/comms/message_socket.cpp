#include "sextant/comms/message_socket.hpp"

#include <array>
#include <cerrno>
#include <system_error>
#include <vector>

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sextant {

std::pair<MessageSocket, MessageSocket> MessageSocket::pair() {
  std::array<int, 2> fds{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, fds.data()) != 0) {
    throw std::system_error(errno, std::system_category(), "a pair of sockets cannot be had");
  }
  // As much as may be had without rights: room for some hundred messages.
  const int bytes = 1 << 20;
  for (const int fd : fds) (void)setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
  return {MessageSocket{fds[0]}, MessageSocket{fds[1]}};
}

bool MessageSocket::is_one(int fd) noexcept {
  int type = 0;
  socklen_t size = sizeof type;
  return getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_SEQPACKET;
}

MessageSocket::~MessageSocket() {
  if (fd_ >= 0) close(fd_);
}

MessageSend MessageSocket::send(std::span<const std::byte> message) const noexcept {
  if (::send(fd_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return MessageSend::sent;
  const bool full = errno == EAGAIN || errno == EINTR || errno == ENOBUFS;
  return full ? MessageSend::full : MessageSend::closed;
}

std::optional<std::span<const std::byte>> MessageSocket::receive(std::span<std::byte> buffer) const noexcept {
  const ssize_t length = recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (length >= 0) return buffer.first(static_cast<std::size_t>(length));
  if (errno == EAGAIN || errno == EINTR) return {};
  return buffer.first(0);
}

bool MessageSocket::wait(std::chrono::milliseconds timeout) const noexcept {
  pollfd watched{fd_, POLLIN, 0};
  return poll(&watched, 1, static_cast<int>(timeout.count())) > 0;
}

bool MessageSocket::wait_any(std::span<const MessageSocket* const> sockets,
                             std::chrono::milliseconds timeout) {
  std::vector<pollfd> watched;
  watched.reserve(sockets.size());
  for (const MessageSocket* socket : sockets) watched.push_back({socket->fd_, POLLIN, 0});
  return poll(watched.data(), watched.size(), static_cast<int>(timeout.count())) > 0;
}

void MessageSocket::finish() const noexcept {
  (void)shutdown(fd_, SHUT_WR);
}

}  // namespace sextant
