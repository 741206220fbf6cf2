#include "ecu/telemetry/telemetry_sender.hpp"

#include <utility>

namespace sextant::ecu {

void TelemetrySender::connect(MessageSocket socket) noexcept {
  socket_ = std::move(socket);
  state_.sent = false;
  statistics_.sent = false;
}

void TelemetrySender::disconnect() noexcept {
  const MessageSocket closed = std::move(socket_);
}

void TelemetrySender::write(const TelemetryIntervalRecord<double>& record, std::uint64_t dropped) noexcept {
  const IntervalMessage message{.sequence = intervals_++, .dropped = dropped, .record = record};
  if (connected() && socket_.send_struct(message) == MessageSend::sent) return;
  ++dropped_;
  dropped_periods_ += record.periods;
}

void TelemetrySender::write(const DriveStateSample& sample) noexcept {
  keep(state_, StateMessage{states_++, sample});
}

void TelemetrySender::write(const RealTimeSample& sample) noexcept {
  keep(statistics_, StatisticsMessage{.sequence = statistics_count_++, .sample = sample});
}

void TelemetrySender::write(const WaveformBatch& batch, std::uint64_t dropped) noexcept {
  const WaveformMessage message{.sequence = waveforms_++, .dropped = dropped, .batch = batch};
  if (!connected() || socket_.send_struct(message) != MessageSend::sent) ++dropped_;
}

void TelemetrySender::send_kept() noexcept {
  send(state_);
  send(statistics_);
}

void TelemetrySender::count_lost(std::span<const std::byte> message) noexcept {
  const auto kind = kind_of(message);
  if (kind == TelemetryMessageKind::interval) {
    ++dropped_;
    if (const auto lost = content_of<IntervalMessage>(message)) dropped_periods_ += lost->record.periods;
  } else if (kind == TelemetryMessageKind::waveform) {
    ++dropped_;
  } else if (kind == TelemetryMessageKind::state) {
    if (const auto lost = content_of<StateMessage>(message)) count_lost(state_, *lost);
  } else if (kind == TelemetryMessageKind::statistics) {
    if (const auto lost = content_of<StatisticsMessage>(message)) count_lost(statistics_, *lost);
  }
}

template <class Message>
void TelemetrySender::keep(Kept<Message>& kept, const Message& message) noexcept {
  if (kept.message && !kept.sent) ++dropped_;
  kept = {message, false};
  send(kept);
}

template <class Message>
void TelemetrySender::count_lost(Kept<Message>& kept, const Message& lost) noexcept {
  // The newest is kept, and is sent again.
  if (kept.message && kept.message->sequence == lost.sequence) {
    kept.sent = false;
  } else {
    ++dropped_;
  }
}

template <class Message>
void TelemetrySender::send(Kept<Message>& kept) noexcept {
  if (!kept.message || kept.sent || !connected()) return;
  kept.sent = socket_.send_struct(*kept.message) == MessageSend::sent;
}

}  // namespace sextant::ecu
