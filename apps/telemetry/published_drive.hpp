#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "sextant/dds/dds_telemetry.hpp"

namespace sextant {

/// A drive whose samples, received through a socket, are published.
class PublishedDrive {
 public:
  explicit PublishedDrive(MessageSocket socket) noexcept : socket_{std::move(socket)} {}

  /// Waits for the first message and opens the topics, with the participant of `first` where that is another
  /// drive; false, with `refused` sent to the drive, where it cannot.
  [[nodiscard]] bool start(const PublishedDrive& first);
  void say_ready() noexcept { (void)socket_.send_struct(AnswerMessage{}); }

  /// Publishes the message that waits; false where none does.
  [[nodiscard]] bool publish(std::span<std::byte> buffer);
  /// The drive has closed its end.
  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

  void report_counts() noexcept;

  [[nodiscard]] const MessageSocket& socket() const noexcept { return socket_; }

 private:
  void refuse(const std::string& sentence);
  void handle(std::span<const std::byte> message);

  MessageSocket socket_;
  std::unique_ptr<DdsTelemetry> dds_{};
  bool is_over_{false};
};

}  // namespace sextant
