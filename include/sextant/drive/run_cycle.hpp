#pragma once

#include <cstdint>

#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/drive.hpp"

namespace sextant {

/// The probe of a control period that nothing observes.
struct NoProbe {
  static constexpr void begins(std::int64_t /*t_ns*/) noexcept SEXTANT_NONBLOCKING {}
  template <class T>
  static constexpr void has_read(const Measurement<T>& /*measurement*/) noexcept SEXTANT_NONBLOCKING {}
  template <class T>
  static constexpr void has_request(const DriveRequest<T>& /*request*/) noexcept SEXTANT_NONBLOCKING {}
  template <class T>
  static constexpr void has_stepped(const DriveOutput<T>& /*output*/) noexcept SEXTANT_NONBLOCKING {}
  static constexpr void has_written() noexcept SEXTANT_NONBLOCKING {}
  static constexpr void has_pushed() noexcept SEXTANT_NONBLOCKING {}
};

/// One control period, the same in every program: read, command, drive, write, telemetry.
/// t_ns: beginning of the period, on the drive's clock [ns].
/// Commands: `DriveRequest<T> latest(std::int64_t t_ns) noexcept`, the newest request.
/// TelemetrySink: `void push(const Telemetry<T>&) noexcept`, never blocks.
/// Probe: the functions of NoProbe; observes the period and changes nothing of it.
/// All three are called below the compile-time check, so they must satisfy it.
template <class T, class Motor, class Commands, class TelemetrySink, class Probe>
void run_cycle(std::int64_t t_ns, DriveIo<T>& io, Commands& commands, Drive<T, Motor>& drive,
               TelemetrySink& telemetry, Probe& probe) noexcept SEXTANT_NONBLOCKING {
  probe.begins(t_ns);
  const Measurement<T> measurement = io.read(t_ns);
  probe.has_read(measurement);
  const DriveRequest<T> request = commands.latest(t_ns);
  probe.has_request(request);
  const DriveOutput<T> output = drive.step(t_ns, measurement, request);
  probe.has_stepped(output);
  io.write(output.pattern);
  probe.has_written();
  telemetry.push(output.telemetry);
  probe.has_pushed();
}

/// The same without a probe.
template <class T, class Motor, class Commands, class TelemetrySink>
void run_cycle(std::int64_t t_ns, DriveIo<T>& io, Commands& commands, Drive<T, Motor>& drive,
               TelemetrySink& telemetry) noexcept SEXTANT_NONBLOCKING {
  NoProbe probe;
  run_cycle(t_ns, io, commands, drive, telemetry, probe);
}

}  // namespace sextant
