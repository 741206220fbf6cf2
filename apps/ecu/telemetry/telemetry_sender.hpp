#pragma once

#include <cstdint>
#include <optional>

#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "sextant/comms/telemetry_samples.hpp"
#include "sextant/core/telemetry_interval.hpp"

namespace sextant::ecu {

/// The drive's end of the way to the process that publishes its telemetry. It never waits: a sample for which
/// the kernel has no room, or nobody to take it, is dropped and counted, and readers see a gap in `sequence`.
/// The newest state and the newest statistics are kept, for those topics hold what is true now: they go as
/// soon as there is room, and again to a process that is new.
class TelemetrySender {
 public:
  /// From now on the process at the other end of this connection takes the samples.
  void connect(MessageSocket socket) noexcept;
  void disconnect() noexcept;
  [[nodiscard]] bool connected() const noexcept { return socket_.fd() >= 0; }
  [[nodiscard]] MessageSocket& socket() noexcept { return socket_; }

  void write(const TelemetryIntervalRecord<double>& record, std::uint64_t dropped) noexcept;
  void write(const DriveStateSample& sample) noexcept;
  void write(const RealTimeSample& sample) noexcept;

  /// Sends what is kept and has not gone yet.
  void send_kept() noexcept;

  /// Samples that nobody took, since start. [-]
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  /// The newest sample of a topic that holds what is true now.
  template <class Message>
  struct Kept {
    std::optional<Message> message{};
    bool sent{false};
  };

  template <class Message>
  void keep(Kept<Message>& kept, const Message& message) noexcept;
  template <class Message>
  void send(Kept<Message>& kept) noexcept;

  MessageSocket socket_{};
  std::uint64_t intervals_{0};
  std::uint64_t states_{0};
  std::uint64_t statistics_count_{0};
  Kept<StateMessage> state_{};
  Kept<StatisticsMessage> statistics_{};
  std::uint64_t dropped_{0};
};

}  // namespace sextant::ecu
