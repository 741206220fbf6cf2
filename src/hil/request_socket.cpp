#include "sextant/hil/request_socket.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

namespace sextant {
namespace {

constexpr std::size_t largest_request = 4096;  // [bytes]

[[noreturn]] void refuse(const std::string& file, const std::string& reason) {
  throw std::runtime_error{"the socket " + file + " cannot be made: " + reason};
}

[[noreturn]] void refuse(const std::string& file, int error) {
  refuse(file, std::generic_category().message(error));
}

sockaddr_un address_of(const std::string& file) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (file.empty() || file.size() >= sizeof address.sun_path)
    refuse(file, "its name must have 1 to " + std::to_string(sizeof address.sun_path - 1) + " bytes");
  std::memcpy(address.sun_path, file.c_str(), file.size());
  return address;
}

int opened(const std::string& file) {
  const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) refuse(file, errno);
  return socket;
}

/// Whether a program answers at this address.
bool answers(const sockaddr_un& address) {
  const int probe = opened(address.sun_path);
  const bool taken = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(probe);
  return taken;
}

/// Removes the socket of a program that has ended.
void make_room(const std::string& file, const sockaddr_un& address) {
  struct stat there{};
  if (::lstat(file.c_str(), &there) != 0) return;
  if (!S_ISSOCK(there.st_mode)) refuse(file, "a file of this name is there and no socket");
  if (answers(address)) refuse(file, "another program answers there");
  ::unlink(file.c_str());
}

/// With the mode 0600 from the beginning: on Linux a socket's file has the mode of the socket.
int listening(const std::string& file) {
  const sockaddr_un address = address_of(file);
  make_room(file, address);
  const int socket = opened(file);
  const bool made = ::fchmod(socket, S_IRUSR | S_IWUSR) == 0 &&
                    ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                    ::listen(socket, 4) == 0;
  if (made) return socket;
  const int error = errno;
  ::close(socket);
  refuse(file, error);
}

}  // namespace

RequestSocket::RequestSocket(const std::string& file, Answer answer)
    : file_{file}, answer_{std::move(answer)}, listening_{listening(file)} {}

RequestSocket::~RequestSocket() {
  ::close(listening_);
  ::unlink(file_.c_str());
}

void RequestSocket::poll() {
  const int client = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  const timeval patience{0, 100'000};
  ::setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ::setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  std::array<char, largest_request> request{};
  // MSG_TRUNC: the packet's own length, also where it is longer than what is taken of it.
  const ssize_t length = ::recv(client, request.data(), request.size(), MSG_TRUNC);
  if (length > 0) {
    const std::string reply = std::size_t(length) > request.size()
                                  ? "the request is longer than " + std::to_string(largest_request) + " bytes"
                                  : answer_({request.data(), std::size_t(length)});
    (void)::send(client, reply.data(), reply.size(), MSG_NOSIGNAL);
  }
  ::close(client);
}

}  // namespace sextant
