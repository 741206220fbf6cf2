#include "sextant/hil/udp_socket.hpp"

#include <cerrno>
#include <charconv>
#include <random>
#include <stdexcept>
#include <system_error>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sextant {
namespace {

sockaddr_in parse(const std::string& key, const std::string& text) {
  const auto malformed = [&]() -> std::runtime_error {
    return std::runtime_error{key + ": \"" + text +
                              "\" is no <IPv4 address>:<port> with a port from 1 to 65535, such as "
                              "\"192.168.10.2:47810\""};
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) throw malformed();
  unsigned port = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, port);
  if (error != std::errc{} || rest != end || port < 1 || port > 65'535) throw malformed();
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) throw malformed();
  return address;
}

const sockaddr* generic(const sockaddr_in& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace

UdpSocket::UdpSocket(const std::string& listen, const std::string& peer) {
  const sockaddr_in own = parse("hil.udp_listen", listen);
  const sockaddr_in other = parse("hil.udp_peer", peer);
  file_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  // The kernel drops datagrams of other senders once the socket is connected.
  const char* problem = nullptr;
  if (file_ < 0) {
    problem = "a UDP socket cannot be opened";
  } else if (bind(file_, generic(own), sizeof own) != 0) {
    problem = "cannot be listened on";
  } else if (connect(file_, generic(other), sizeof other) != 0) {
    problem = "has no way to hil.udp_peer";
  }
  if (problem == nullptr) return;
  const std::string why = std::generic_category().message(errno);
  if (file_ >= 0) close(file_);
  throw std::runtime_error("hil.udp_listen: \"" + listen + "\" " + problem + " (\"" + peer + "\"): " + why);
}

UdpSocket::~UdpSocket() {
  close(file_);
}

std::uint32_t random_generation() {
  std::random_device random;
  std::uint32_t generation = 0;
  while (generation == 0) generation = static_cast<std::uint32_t>(random());
  return generation;
}

// Calls of a socket that does not block; the kernel's network path bounds their time.
SEXTANT_TRUSTED_BEGIN

bool UdpSocket::send(std::span<const std::byte> datagram) const noexcept SEXTANT_NONBLOCKING {
  // The kernel reports the refusal of an earlier datagram once, by the next call.
  for (int n = 0; n < 2; ++n) {
    if (::send(file_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return true;
    if (errno != ECONNREFUSED) return false;
  }
  return false;
}

std::size_t UdpSocket::receive(std::span<std::byte> buffer) const noexcept SEXTANT_NONBLOCKING {
  for (int n = 0; n < 2; ++n) {
    const ssize_t length = recv(file_, buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC);
    if (length > 0) return static_cast<std::size_t>(length);
    if (length < 0 && errno != ECONNREFUSED) return 0;
  }
  return 0;
}

SEXTANT_TRUSTED_END

}  // namespace sextant
