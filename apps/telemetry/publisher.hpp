#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "sextant/dds/dds_telemetry.hpp"

namespace sextant {

/// Publishes over DDS what a drive hands over through a socket, until the drive says that it was all or is
/// gone.
class Publisher {
 public:
  explicit Publisher(MessageSocket socket) noexcept : socket_{std::move(socket)} {}

  /// The exit status of the process: 0 where DDS ran.
  int run();

 private:
  /// Waits for the first message and starts DDS; false where it cannot, which the drive is told.
  [[nodiscard]] bool start();
  void refuse(const std::string& sentence);
  void publish();
  void take(std::span<const std::byte> message);
  void report_counts();

  MessageSocket socket_;
  std::unique_ptr<DdsTelemetry> dds_{};
};

}  // namespace sextant
