#pragma once

#include <chrono>
#include <vector>

#include "sextant/comms/message_socket.hpp"
#include "telemetry/published_drive.hpp"

namespace sextant {

/// Publishes the samples of the drives of a process over DDS, with one participant, until each drive has
/// closed its socket.
class Publisher {
 public:
  /// A socket for each drive, at least one.
  explicit Publisher(std::vector<MessageSocket> sockets);

  /// The exit status of the process: `done` where DDS ran.
  int run();

 private:
  /// False where DDS cannot start for one of the drives.
  [[nodiscard]] bool start();
  void publish();
  /// Waits for a message of any drive.
  void wait();
  /// Publishes the next message of each drive; false where there is none.
  [[nodiscard]] bool publish_next();
  void report_when_due();

  std::vector<std::byte> buffer_;
  std::vector<PublishedDrive> drives_{};
  std::chrono::steady_clock::time_point next_report_{};
};

}  // namespace sextant
