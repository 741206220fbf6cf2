#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "ecu/command_probe.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/realtime/cycle_counter.hpp"
#include "sextant/realtime/miss.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant::ecu {

/// How long the stages of one control period took. [ns]
using StageRecord = std::array<std::uint32_t, stage_count>;

/// The time stamps of the control thread within its work, one at the end of each stage. It belongs to the
/// control thread and costs one reading of the processor's counter a stage.
class StageProbe {
 public:
  /// gap_limit_ns: two stamps further apart are a gap [ns].
  StageProbe(bool on, std::int64_t gap_limit_ns) noexcept
      : counter_{on ? 5'000'000 : 0}, on_{on}, gap_limit_ns_{gap_limit_ns} {}

  /// At a wake-up: a new chain of stamps.
  void wake() noexcept SEXTANT_NONBLOCKING {
    if (on_) first_ = last_ = counter_.ticks();
  }

  /// What follows is the first stage of a period.
  void begin() noexcept SEXTANT_NONBLOCKING {
    if (on_) see(step_ns(), GapPlace::between);
  }

  /// The stage ends here; the next begins.
  void end(Stage stage) noexcept SEXTANT_NONBLOCKING {
    if (!on_) return;
    const std::int64_t ns = step_ns();
    see(ns, static_cast<GapPlace>(stage));
    record_[static_cast<std::size_t>(stage)] =
        static_cast<std::uint32_t>(std::min<std::int64_t>(ns, std::numeric_limits<std::uint32_t>::max()));
  }

  /// At the end of a wake-up's work, which took body_ns by the clock [ns]: what the stamps do not cover.
  void finish(std::int64_t body_ns) noexcept SEXTANT_NONBLOCKING {
    if (!on_) return;
    see(step_ns(), GapPlace::between);
    see(body_ns - counter_.elapsed_ns(first_, last_), GapPlace::between);
  }

  [[nodiscard]] bool on() const noexcept SEXTANT_NONBLOCKING { return on_; }
  /// Of the last period.
  [[nodiscard]] const StageRecord& record() const noexcept SEXTANT_NONBLOCKING { return record_; }
  /// A time between two stamps that the control thread took itself. [ns]
  void see(std::int64_t duration_ns, GapPlace where) noexcept SEXTANT_NONBLOCKING {
    gap_.see(duration_ns, where, gap_limit_ns_);
    longest_ns_ = std::max(longest_ns_, duration_ns);
  }

  /// What can have made a wake-up late, until the control thread clears it or lets it fade.
  [[nodiscard]] const Gap& gap() const noexcept SEXTANT_NONBLOCKING { return gap_; }
  void clear_gap() noexcept SEXTANT_NONBLOCKING { gap_ = {}; }
  void fade_gap(std::int64_t latency_ns) noexcept SEXTANT_NONBLOCKING {
    gap_.fade(latency_ns, gap_limit_ns_);
  }

  /// The longest since the last call, whatever came of it. [ns]
  [[nodiscard]] std::int64_t take_longest_ns() noexcept SEXTANT_NONBLOCKING {
    return std::exchange(longest_ns_, 0);
  }

 private:
  std::int64_t step_ns() noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t now = counter_.ticks();
    const std::int64_t ns = counter_.elapsed_ns(last_, now);
    last_ = now;
    return ns;
  }

  CycleCounter counter_;
  bool on_;
  std::int64_t gap_limit_ns_;
  std::uint64_t first_{0};
  std::uint64_t last_{0};
  StageRecord record_{};
  Gap gap_{};
  std::int64_t longest_ns_{0};
};

// The ends of the cycle that every program shares, with time stamps around their calls; so the cycle itself
// stays free of them.

/// A power stage with time stamps.
class StampedIo final : public DriveIo<double> {
 public:
  StampedIo(DriveIo<double>& io, StageProbe& probe, CommandProbe& command_probe) noexcept
      : io_{io}, probe_{probe}, command_probe_{command_probe} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    probe_.begin();
    const Measurement<double> measurement = io_.read(t_ns);
    probe_.end(Stage::read);
    return measurement;
  }

  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    probe_.end(Stage::drive);
    io_.write(pattern);
    command_probe_.written();
    probe_.end(Stage::write);
  }

 private:
  DriveIo<double>& io_;
  StageProbe& probe_;
  CommandProbe& command_probe_;
};

/// A source of commands with time stamps.
template <class Commands>
class StampedCommands {
 public:
  StampedCommands(Commands& commands, StageProbe& probe, CommandProbe& command_probe) noexcept
      : commands_{commands}, probe_{probe}, command_probe_{command_probe} {}

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    const DriveRequest<double> request = commands_.latest(t_ns);
    command_probe_.see(request.command);
    probe_.end(Stage::commands);
    return request;
  }

 private:
  Commands& commands_;
  StageProbe& probe_;
  CommandProbe& command_probe_;
};

/// A sink of telemetry with time stamps; the last of a period, so it hands over the period's record.
template <class Sink>
class StampedTelemetry {
 public:
  StampedTelemetry(Sink& sink, StageProbe& probe, Ring<StageRecord>& records) noexcept
      : sink_{sink}, probe_{probe}, records_{records} {}

  void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING {
    sink_.push(telemetry);
    probe_.end(Stage::push);
    if (probe_.on()) records_.push(probe_.record());
  }

 private:
  Sink& sink_;
  StageProbe& probe_;
  Ring<StageRecord>& records_;
};

}  // namespace sextant::ecu
