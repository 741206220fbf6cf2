#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <sys/socket.h>

namespace sextant {

/// The system's text for an error number.
[[nodiscard]] std::string error_text(int error);

/// A socket that closes itself.
class Socket {
 public:
  Socket() noexcept = default;
  explicit Socket(int fd) noexcept : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  Socket& operator=(Socket&&) = delete;
  ~Socket();

  [[nodiscard]] int fd() const noexcept { return fd_; }

  /// setsockopt with an int; false with errno on failure.
  [[nodiscard]] bool set(int level, int option, int value) const noexcept;

 private:
  int fd_{-1};
};

/// One received datagram or frame with the kernel's data about it.
struct Reception {
  std::ptrdiff_t length{};     ///< as recvmsg; negative with `error` set [bytes]
  int error{};                 ///< errno
  int flags{};                 ///< msg_flags
  std::int64_t received_ns{};  ///< arrival on CLOCK_MONOTONIC [ns]
  bool has_overflow{false};    ///< the kernel reported its drops
  std::uint32_t overflow{};    ///< frames that the socket dropped since it was opened [-]
  sockaddr_storage sender{};   ///< where it came from
};

/// Receives from a socket with SO_TIMESTAMPNS and SO_RXQ_OVFL, and puts the kernel's stamp of the wall clock
/// on the monotonic clock. An arrival cannot lie before the socket was last seen empty nor after now: a stamp
/// outside comes from the other side of a wall-clock change and is replaced by the time of reading.
class Receiver {
 public:
  /// Waits for input for at most `timeout`. Returns poll's result; errno with a negative one.
  [[nodiscard]] int wait(int fd, std::chrono::nanoseconds timeout) noexcept;

  /// Reads what has arrived without waiting; `error` is EAGAIN where nothing has.
  [[nodiscard]] Reception read(int fd, std::span<std::byte> buffer) noexcept;

 private:
  std::int64_t empty_ns_{0};
};

}  // namespace sextant
