#pragma once

#include <cstdint>

#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/drive.hpp"

namespace sextant {

/// One control period, the same in every program: read, command, drive, write, telemetry.
/// t_ns: beginning of the period, on the drive's clock [ns].
/// Commands: `DriveRequest<T> latest(std::int64_t t_ns) noexcept`, the newest request.
/// TelemetrySink: `void push(const Telemetry<T>&) noexcept`, never blocks.
/// Both are called below the compile-time check, so they must satisfy it.
template <class T, class Motor, class Commands, class TelemetrySink>
void run_cycle(std::int64_t t_ns, DriveIo<T>& io, Commands& commands, Drive<T, Motor>& drive,
               TelemetrySink& telemetry) noexcept SEXTANT_NONBLOCKING {
  const Measurement<T> measurement = io.read(t_ns);
  const DriveRequest<T> request = commands.latest(t_ns);
  const DriveOutput<T> output = drive.step(t_ns, measurement, request);
  io.write(output.pattern);
  telemetry.push(output.telemetry);
}

}  // namespace sextant
