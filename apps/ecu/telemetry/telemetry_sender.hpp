#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "sextant/comms/telemetry_samples.hpp"
#include "sextant/core/telemetry_interval.hpp"

namespace sextant::ecu {

/// Sends telemetry to the process that publishes it. Never waits: a sample without room in the kernel's
/// buffer, or without a process, is dropped and counted, and readers see a gap in `sequence`. The newest
/// state and the newest statistics are kept, because those topics hold the current state: they are sent as
/// soon as there is room, and again to a restarted process. Messages that a process had not received when it
/// ended are counted too.
class TelemetrySender {
 public:
  /// Sends the following samples to the process at the other end of this connection.
  void connect(MessageSocket socket) noexcept;
  void disconnect() noexcept;
  [[nodiscard]] bool connected() const noexcept { return socket_.fd() >= 0; }
  [[nodiscard]] MessageSocket& socket() noexcept { return socket_; }

  void write(const TelemetryIntervalRecord<double>& record, std::uint64_t dropped) noexcept;
  void write(const DriveStateSample& sample) noexcept;
  void write(const RealTimeSample& sample) noexcept;
  void write(const WaveformBatch& batch, std::uint64_t dropped) noexcept;

  /// True while the publisher knows a reader of DriveWaveform. It stays without a connection, so that batches
  /// are numbered on and readers see what is missing.
  [[nodiscard]] bool waveform_is_read() const noexcept { return waveform_is_read_; }
  void set_waveform_is_read(bool is_read) noexcept { waveform_is_read_ = is_read; }

  /// Sends the kept samples that have not been sent.
  void send_kept() noexcept;

  /// A message that was sent and not received by the process before its end. [bytes of the message]
  void count_lost(std::span<const std::byte> message) noexcept;

  /// Samples dropped since start. [-]
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  /// Control periods of the intervals among them. [-]
  [[nodiscard]] std::uint64_t dropped_periods() const noexcept { return dropped_periods_; }

 private:
  /// The newest sample of a topic that holds the current state.
  template <class Message>
  struct Kept {
    std::optional<Message> message{};
    bool sent{false};
  };

  template <class Message>
  void keep(Kept<Message>& kept, const Message& message) noexcept;
  template <class Message>
  void send(Kept<Message>& kept) noexcept;
  template <class Message>
  void count_lost(Kept<Message>& kept, const Message& lost) noexcept;

  MessageSocket socket_{};
  std::uint64_t intervals_{0};
  std::uint64_t states_{0};
  std::uint64_t statistics_count_{0};
  std::uint64_t waveforms_{0};
  bool waveform_is_read_{false};
  Kept<StateMessage> state_{};
  Kept<StatisticsMessage> statistics_{};
  std::uint64_t dropped_{0};
  std::uint64_t dropped_periods_{0};
};

}  // namespace sextant::ecu
