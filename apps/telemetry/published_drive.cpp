#include "telemetry/published_drive.hpp"

#include <chrono>
#include <cstring>
#include <exception>
#include <optional>
#include <string_view>
#include <vector>

namespace sextant {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t longest_start = 1 << 18;  // with its texts

}  // namespace

bool PublishedDrive::start(const PublishedDrive& first) {
  std::vector<std::byte> buffer(longest_start);
  while (!socket_.wait(1000ms)) {
  }
  const std::span<const std::byte> message = socket_.receive(buffer).value_or(std::span<const std::byte>{});
  const auto head = content_of<StartMessage>(message);
  if (!head || head->kind != TelemetryMessageKind::start || head->version != telemetry_messages_version) {
    refuse("sextant-telemetry is of another build than sextant-ecu; install both together");
    return false;
  }
  const std::string_view texts = text_after<StartMessage>(message);
  try {
    if (first.dds_) {
      dds_ = std::make_unique<DdsTelemetry>(*first.dds_, head->drive_id);
    } else {
      dds_ = std::make_unique<DdsTelemetry>(DdsTelemetry::Parameters{
          .domain_id = head->domain_id,
          .drive_id = head->drive_id,
          .configuration = std::string{texts.substr(0, head->configuration_bytes)},
          .configuration_source = std::string{texts.substr(head->configuration_bytes)},
          .type_information = head->type_information});
    }
  } catch (const std::exception& problem) {
    refuse(problem.what());
    return false;
  }
  return true;
}

void PublishedDrive::refuse(const std::string& sentence) {
  constexpr AnswerMessage head{.kind = TelemetryMessageKind::refused};
  std::vector<std::byte> message(sizeof head + sentence.size());
  std::memcpy(message.data(), &head, sizeof head);
  std::memcpy(message.data() + sizeof head, sentence.data(), sentence.size());
  (void)socket_.send(message);
}

bool PublishedDrive::publish(std::span<std::byte> buffer) {
  const auto message = socket_.receive(buffer);
  if (!message) return false;
  is_over_ = message->empty();
  if (!is_over_) handle(*message);
  return true;
}

void PublishedDrive::handle(std::span<const std::byte> message) {
  const auto kind = kind_of(message);
  if (kind == TelemetryMessageKind::interval) {
    if (const auto m = content_of<IntervalMessage>(message)) {
      (void)dds_->write(m->record, m->dropped, m->sequence);
    }
  } else if (kind == TelemetryMessageKind::state) {
    if (const auto m = content_of<StateMessage>(message)) (void)dds_->write(m->sample(), m->sequence);
  } else if (kind == TelemetryMessageKind::statistics) {
    if (const auto m = content_of<StatisticsMessage>(message)) (void)dds_->write(m->sample, m->sequence);
  } else if (kind == TelemetryMessageKind::waveform) {
    if (const auto m = content_of<WaveformMessage>(message)) {
      (void)dds_->write(m->batch, m->dropped, m->sequence);
    }
  }
}

void PublishedDrive::report_counts() noexcept {
  const DdsTelemetryCounts counts = dds_->counts();
  (void)socket_.send_struct(CountsMessage{.written = counts.written,
                                          .refused = counts.refused,
                                          .failed = counts.failed,
                                          .incompatible_readers = dds_->incompatible_readers(),
                                          .waveform_readers = dds_->waveform_readers()});
}

}  // namespace sextant
