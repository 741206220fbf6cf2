#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "sextant/dds/dds_telemetry.hpp"

namespace sextant {

/// Publishes the samples of a drive, received through a socket, over DDS, until the drive closes its end.
class Publisher {
 public:
  explicit Publisher(MessageSocket socket) noexcept : socket_{std::move(socket)} {}

  /// The exit status of the process: `done` where DDS ran.
  int run();

 private:
  /// Waits for the first message and starts DDS; false, with `refused` sent to the drive, where it cannot.
  [[nodiscard]] bool start();
  void refuse(const std::string& sentence);
  void publish();
  void handle(std::span<const std::byte> message);
  void report_when_due();
  void report_counts();

  MessageSocket socket_;
  std::unique_ptr<DdsTelemetry> dds_{};
  std::chrono::steady_clock::time_point next_report_{};
};

}  // namespace sextant
