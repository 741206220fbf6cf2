#include "ecu/telemetry/telemetry_connection.hpp"

#include <array>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

namespace sextant::ecu {

void TelemetryConnection::open() {
  auto [own, its] = MessageSocket::pair();
  its_end_ = std::move(its);
  is_ready_ = false;
  refusal_.clear();
  earlier_ = counts();
  counts_ = {};
  sender_->connect(std::move(own));
}

void TelemetryConnection::send_start(StartMessage head, const std::string& texts) {
  head.drive_id = drive_id_;
  std::vector<std::byte> message(sizeof head + texts.size());
  std::memcpy(message.data(), &head, sizeof head);
  std::memcpy(message.data() + sizeof head, texts.data(), texts.size());
  (void)sender_->socket().send(message);
}

bool TelemetryConnection::receive(bool is_discovering) {
  std::array<std::byte, 4096> buffer{};
  bool any = false;
  while (const auto message = sender_->socket().receive(buffer)) {
    if (message->empty()) return any;
    any = true;
    handle(*message, is_discovering);
  }
  return any;
}

void TelemetryConnection::handle(std::span<const std::byte> message, bool is_discovering) {
  const auto kind = kind_of(message);
  if (kind == TelemetryMessageKind::ready) is_ready_ = true;
  if (kind == TelemetryMessageKind::refused) refusal_ = text_after<AnswerMessage>(message);
  if (kind == TelemetryMessageKind::counts) {
    counts_ = content_of<CountsMessage>(message).value_or(counts_);
    const bool is_read = counts_.waveform_readers > 0;
    if (is_read || !is_discovering) sender_->set_waveform_is_read(is_read);
  }
}

void TelemetryConnection::wait() {
  (void)sender_->socket().wait(std::chrono::milliseconds{100});
}

void TelemetryConnection::close() {
  std::array<std::byte, sizeof(WaveformMessage)> buffer{};
  while (const auto message = its_end_.receive(buffer)) {
    if (message->empty()) break;
    sender_->count_lost(*message);
  }
  sender_->disconnect();
  const MessageSocket closed = std::move(its_end_);
}

CountsMessage TelemetryConnection::counts() const noexcept {
  CountsMessage sum = counts_;
  sum.written += earlier_.written;
  sum.refused += earlier_.refused;
  sum.failed += earlier_.failed;
  sum.incompatible_readers += earlier_.incompatible_readers;
  return sum;
}

}  // namespace sextant::ecu
