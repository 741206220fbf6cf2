#include "telemetry/publisher.hpp"

#include <chrono>
#include <cstddef>
#include <cstring>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

#include "common/exit_status.hpp"

namespace sextant {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t longest_message = 1 << 18;  // the first, with its texts

}  // namespace

int Publisher::run() {
  alarm(publisher_hang_limit_s);
  if (!start()) return ExitStatus::refused;
  (void)socket_.send_struct(AnswerMessage{});
  publish();
  report_counts();
  dds_.reset();
  return ExitStatus::done;
}

bool Publisher::start() {
  std::vector<std::byte> buffer(longest_message);
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
    dds_ = std::make_unique<DdsTelemetry>(
        DdsTelemetry::Parameters{.domain_id = head->domain_id,
                                 .drive_id = head->drive_id,
                                 .configuration = std::string{texts.substr(0, head->configuration_bytes)},
                                 .configuration_source = std::string{texts.substr(head->configuration_bytes)},
                                 .type_information = head->type_information});
  } catch (const std::exception& problem) {
    refuse(problem.what());
    return false;
  }
  return true;
}

void Publisher::refuse(const std::string& sentence) {
  constexpr AnswerMessage head{.kind = TelemetryMessageKind::refused};
  std::vector<std::byte> message(sizeof head + sentence.size());
  std::memcpy(message.data(), &head, sizeof head);
  std::memcpy(message.data() + sizeof head, sentence.data(), sentence.size());
  (void)socket_.send(message);
}

void Publisher::publish() {
  std::vector<std::byte> buffer(longest_message);
  constexpr std::chrono::nanoseconds every{publisher_reports_every_ns};
  for (;;) {
    report_when_due();
    (void)socket_.wait(std::chrono::duration_cast<std::chrono::milliseconds>(every));
    while (const auto message = socket_.receive(buffer)) {
      if (message->empty()) return;
      handle(*message);
      report_when_due();  // also while messages arrive faster than they are published
    }
  }
}

void Publisher::report_when_due() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_report_) return;
  next_report_ = now + std::chrono::nanoseconds{publisher_reports_every_ns};
  alarm(publisher_hang_limit_s);
  report_counts();
}

void Publisher::handle(std::span<const std::byte> message) {
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

void Publisher::report_counts() {
  const DdsTelemetryCounts counts = dds_->counts();
  CountsMessage message{.written = counts.written,
                        .refused = counts.refused,
                        .failed = counts.failed,
                        .incompatible_readers = dds_->incompatible_readers(),
                        .waveform_readers = dds_->waveform_readers()};
  (void)socket_.send_struct(message);
}

}  // namespace sextant
