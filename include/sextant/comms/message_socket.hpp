#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace sextant {

enum class MessageSend : std::uint8_t {
  sent,
  full,   ///< the kernel's buffer has no room; nothing was sent
  closed  ///< the other end is closed
};

/// One end of a connection between two processes of a machine: whole messages, in order (SOCK_SEQPACKET).
/// Only `wait` waits. The processes share no memory: when the other one ends in any way, the connection is
/// closed.
class MessageSocket {
 public:
  /// Two connected ends, both close-on-exec. Throws std::system_error.
  [[nodiscard]] static std::pair<MessageSocket, MessageSocket> pair();

  /// True where the descriptor is such an end.
  [[nodiscard]] static bool is_one(int fd) noexcept;

  MessageSocket() noexcept = default;
  /// Takes the descriptor over.
  explicit MessageSocket(int fd) noexcept : fd_{fd} {}
  MessageSocket(MessageSocket&& other) noexcept : fd_{std::exchange(other.fd_, -1)} {}
  MessageSocket& operator=(MessageSocket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  MessageSocket(const MessageSocket&) = delete;
  MessageSocket& operator=(const MessageSocket&) = delete;
  ~MessageSocket();

  [[nodiscard]] int fd() const noexcept { return fd_; }

  MessageSend send(std::span<const std::byte> message) const noexcept;
  /// A plain struct as one message.
  template <class T>
  MessageSend send_struct(const T& message) const noexcept {
    static_assert(std::is_trivially_copyable_v<T>);
    return send(std::as_bytes(std::span{&message, 1}));
  }

  /// The next message, in `buffer`, cut to its size. Empty optional: no message has arrived; empty message:
  /// the connection is closed.
  [[nodiscard]] std::optional<std::span<const std::byte>> receive(std::span<std::byte> buffer) const noexcept;

  /// Waits for a message or the end of the connection, for at most `timeout`; true where one has come.
  [[nodiscard]] bool wait(std::chrono::milliseconds timeout) const noexcept;

  /// The same of several: true where one of them has a message or has ended.
  [[nodiscard]] static bool wait_any(std::span<const MessageSocket* const> sockets,
                                     std::chrono::milliseconds timeout);

  /// Ends the sending direction; messages sent before still arrive, and messages can still be received.
  void finish() const noexcept;

 private:
  int fd_{-1};
};

}  // namespace sextant
