#pragma once

#include <cstdint>

#include "ecu/timing/command_probe.hpp"
#include "ecu/timing/stage_probe.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant::ecu {

// Power stage, commands and telemetry sink of `run_cycle` with time stamps around their calls: the cycle
// itself has none.

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
    command_probe_.add(request.command);
    probe_.end(Stage::commands);
    return request;
  }

 private:
  Commands& commands_;
  StageProbe& probe_;
  CommandProbe& command_probe_;
};

/// A telemetry sink with time stamps; called last in a period, it queues the period's stage record.
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
