#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "sextant/comms/telemetry_samples.hpp"
#include "sextant/comms/waveform_batch.hpp"
#include "sextant/core/telemetry_interval.hpp"

namespace sextant {

/// @file
/// The messages between the drives of a process and the process that publishes their telemetry, through a
/// `MessageSocket` for each drive. Both are programs of one build: a struct is sent as its bytes in memory.
/// The publisher compares version and size of the first message.

constexpr std::uint32_t telemetry_messages_version = 3;

/// File descriptor of the publisher's end of the first drive's socket; those of the others follow it. [-]
constexpr int telemetry_process_descriptor = 3;

/// The publisher sends CountsMessage at least this often, whatever it has to publish: the drive notices by
/// them that it runs. [ns]
constexpr std::int64_t publisher_reports_every_ns = 100'000'000;

/// A publisher that does not get on for this long, as when a library hangs, is ended by the kernel. [s]
constexpr unsigned int publisher_hang_limit_s = 30;

enum class TelemetryMessageKind : std::uint32_t {
  // drive → publisher
  start = 1,  ///< StartMessage and two texts: configuration, source of the configuration
  interval,
  state,
  statistics,
  waveform,
  // publisher → drive
  ready,    ///< DDS has started
  refused,  ///< DDS cannot start; a text, one sentence
  counts
};

/// The first message.
struct StartMessage {
  TelemetryMessageKind kind{TelemetryMessageKind::start};
  std::uint32_t version{telemetry_messages_version};
  std::uint32_t domain_id{0};
  std::uint32_t drive_id{1};
  std::uint32_t configuration_bytes{0};  ///< length of the first text; the rest is the second [-]
  bool type_information{true};           ///< see DdsTelemetry::Parameters
};

/// A sample of DriveTelemetry.
struct IntervalMessage {
  TelemetryMessageKind kind{TelemetryMessageKind::interval};
  std::uint64_t sequence{};
  std::uint64_t dropped{};
  TelemetryIntervalRecord<double> record{};
};

/// A sample of DriveState.
struct StateMessage {
  StateMessage() = default;
  StateMessage(std::uint64_t number, const DriveStateSample& given) noexcept
      : sequence{number}, state{given} {
    const std::size_t bytes = std::min(given.reason.size(), reason.size() - 1);
    std::copy_n(given.reason.begin(), bytes, reason.begin());
    state.reason = {};
  }

  /// The sample; its reason refers to this message and must not outlive it.
  [[nodiscard]] DriveStateSample sample() const noexcept {
    DriveStateSample result = state;
    result.reason = std::string_view{reason.data()};
    return result;
  }

  TelemetryMessageKind kind{TelemetryMessageKind::state};
  std::uint64_t sequence{};
  DriveStateSample state{};        ///< without the reason
  std::array<char, 128> reason{};  ///< longer than the published 64 bytes; the publisher cuts it
};

/// A sample of RealTimeStatistics.
struct StatisticsMessage {
  TelemetryMessageKind kind{TelemetryMessageKind::statistics};
  std::uint64_t sequence{};
  RealTimeSample sample{};
};

/// A sample of DriveWaveform.
struct WaveformMessage {
  TelemetryMessageKind kind{TelemetryMessageKind::waveform};
  std::uint64_t sequence{};
  std::uint64_t dropped{};
  WaveformBatch batch{};
};

/// Reply of the publisher: `ready`, or the head of `refused`.
struct AnswerMessage {
  TelemetryMessageKind kind{TelemetryMessageKind::ready};
};

/// Since the publisher's start, but for the readers. [-]
struct CountsMessage {
  TelemetryMessageKind kind{TelemetryMessageKind::counts};
  std::uint64_t written{};
  std::uint64_t refused{};
  std::uint64_t failed{};
  std::uint64_t incompatible_readers{};
  std::uint32_t waveform_readers{};  ///< matched now: the drive sends waveforms while there is one
};

/// Kind of a message; empty for a message that is too short.
[[nodiscard]] inline std::optional<TelemetryMessageKind> kind_of(
    std::span<const std::byte> message) noexcept {
  TelemetryMessageKind kind{TelemetryMessageKind::start};
  if (message.size() < sizeof kind) return {};
  std::memcpy(&kind, message.data(), sizeof kind);
  return kind;
}

/// The struct at the beginning of a message; empty for a message that is shorter.
template <class T>
[[nodiscard]] std::optional<T> content_of(std::span<const std::byte> message) noexcept {
  static_assert(std::is_trivially_copyable_v<T>);
  if (message.size() < sizeof(T)) return {};
  T content{};
  std::memcpy(&content, message.data(), sizeof(T));
  return content;
}

/// The text that follows a struct of type T.
template <class T>
[[nodiscard]] std::string_view text_after(std::span<const std::byte> message) noexcept {
  if (message.size() <= sizeof(T)) return {};
  const std::span<const std::byte> text = message.subspan(sizeof(T));
  return {reinterpret_cast<const char*>(text.data()), text.size()};
}

}  // namespace sextant
