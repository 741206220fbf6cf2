#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "ecu/telemetry/telemetry_sender.hpp"
#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"

namespace sextant::ecu {

/// The connection of a drive's TelemetrySender to the process that publishes, through its restarts. The
/// publisher's end of the connection is kept open here too: what a process has not received before its end is
/// still in it, and is counted as dropped.
class TelemetryConnection {
 public:
  /// The sender is not owned and must outlive this object.
  TelemetryConnection(std::uint32_t drive_id, TelemetrySender& sender) noexcept
      : drive_id_{drive_id}, sender_{&sender} {}

  [[nodiscard]] std::uint32_t drive_id() const noexcept { return drive_id_; }
  /// The publisher's end, for a process that starts.
  [[nodiscard]] int descriptor() const noexcept { return its_end_.fd(); }

  /// Connects the sender for a process that starts, and forgets the replies of the one before.
  void open();
  /// The first message. texts: configuration and its source.
  void send_start(StartMessage head, const std::string& texts);

  /// Receives the messages of the process. True where there were some. is_discovering: it may not have found
  /// the readers that there are yet.
  bool receive(bool is_discovering);
  /// Waits for a message for a while.
  void wait();
  void send_kept() noexcept { sender_->send_kept(); }
  /// No further message follows.
  void finish() noexcept { sender_->socket().finish(); }
  /// After the end of the process: closes the connection and counts what is left in it.
  void close();

  [[nodiscard]] bool is_ready() const noexcept { return is_ready_; }
  /// Why DDS cannot start for this drive; empty where it can.
  [[nodiscard]] const std::string& refusal() const noexcept { return refusal_; }
  /// Of all processes together.
  [[nodiscard]] CountsMessage counts() const noexcept;

 private:
  void handle(std::span<const std::byte> message, bool is_discovering);

  std::uint32_t drive_id_;
  TelemetrySender* sender_;
  MessageSocket its_end_{};
  bool is_ready_{false};
  std::string refusal_{};
  CountsMessage counts_{};   // of this process
  CountsMessage earlier_{};  // of those before it
};

}  // namespace sextant::ecu
