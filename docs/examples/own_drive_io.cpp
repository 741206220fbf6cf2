// A DriveIo for hardware of your own, complete: an inverter behind a block of registers, as an FPGA on the
// bus of a processor offers it. What is yours is the block's layout, its scaling and the way to map it; the
// rest stays. The end of the file runs a drive on a stand-in for the block, so that this page is compiled and
// run by the tests.
#include <cstdint>
#include <cstdio>

#include "sextant/conformance/check_drive_io.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/drive/resolved.hpp"
#include "sextant/drive/run_cycle.hpp"

namespace {

using sextant::GatePattern;
using sextant::LegState;
using sextant::Measurement;

/// The registers. On a target they are mapped once, before the first period, for instance from /dev/uio0.
struct InverterRegisters {
  volatile std::uint32_t period_count;  // grows with each sample of the converters
  volatile std::uint32_t fault;         // gate driver: desaturation, supply, over-temperature; 0 is good
  volatile std::int16_t i_a, i_b, i_c;  // phase currents [12.5 mA]
  volatile std::uint16_t u_dc;          // [25 mV]
  volatile std::int32_t speed;          // of the encoder [1/1000 rad/s]
  // The pattern: shadow registers, in force from the next sample on. Legs of a segment, two bits each, 0 off.
  volatile std::uint32_t segment_count;
  volatile std::uint32_t gates[GatePattern::capacity];
  volatile std::uint32_t ticks[GatePattern::capacity];  // duration [10 ns]
  volatile std::uint32_t watchdog;  // the hardware turns the gates off 200 us after the last write
};

/// The inverter behind the registers. A pattern acts from the sample after it was written, which is a
/// delay of one period: `drive.actuation_delay_periods = 1`.
class RegisterDriveIo final : public sextant::DriveIo<double> {
 public:
  RegisterDriveIo(InverterRegisters& registers, std::int32_t period_ns) noexcept
      : registers_{registers}, period_ns_{period_ns} {}

  [[nodiscard]] Measurement<double> read(std::int64_t /*t_ns*/) noexcept SEXTANT_NONBLOCKING override {
    const std::uint32_t count = registers_.period_count;
    const std::uint32_t samples = count - last_count_;
    last_count_ = count;
    Measurement<double> m;
    m.i_abc = {12.5e-3 * registers_.i_a, 12.5e-3 * registers_.i_b, 12.5e-3 * registers_.i_c};
    m.u_dc = 25e-3 * registers_.u_dc;
    m.omega_m = 1e-3 * registers_.speed;
    // What was applied over the period that ends now was written two periods ago.
    m.applied = in_force_;
    in_force_ = written_;
    // After no new sample, or more than one, the applied pattern is unknown: not plausible.
    m.plausible = started_ ? samples == 1 && registers_.fault == 0 : registers_.fault == 0;
    started_ = true;
    return m;
  }

  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    // An empty pattern means gates off.
    written_ = pattern.segments().empty() ? GatePattern{sextant::gates_off, period_ns_} : pattern;
    std::uint32_t n = 0;
    for (const sextant::GateSegment& segment : written_.segments()) {
      const sextant::SwitchState s = segment.state;
      registers_.gates[n] = bits(s.a()) | bits(s.b()) << 2U | bits(s.c()) << 4U;
      registers_.ticks[n] = std::uint32_t(segment.duration_ns) / ns_per_tick;
      ++n;
    }
    registers_.segment_count = n;
    registers_.watchdog = ++beats_;
  }

 private:
  static std::uint32_t bits(LegState leg) noexcept SEXTANT_NONBLOCKING {
    return leg == LegState::off ? 0U : leg == LegState::high ? 2U : 1U;
  }

  static constexpr std::uint32_t ns_per_tick = 10;

  InverterRegisters& registers_;
  std::int32_t period_ns_;
  GatePattern written_{sextant::gates_off, period_ns_};
  GatePattern in_force_{sextant::gates_off, period_ns_};
  std::uint32_t last_count_{0};
  std::uint32_t beats_{0};
  bool started_{false};
};

/// Disable, then enable with 10 N·m.
struct Commands {
  [[nodiscard]] sextant::DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    sextant::DriveRequest<double> request;
    request.command.enable = t_ns >= 1'000'000;
    request.command.torque = 10.0;
    request.command.torque_limit = 150.0;
    request.command.received_ns = t_ns;
    request.command.sequence = std::uint64_t(t_ns / 1'000'000 + 1);
    request.command.e2e = sextant::E2eState::valid;
    return request;
  }
};

struct LastTelemetry {
  void push(const sextant::Telemetry<double>& t) noexcept { last = t; }
  sextant::Telemetry<double> last{};
};

int failures = 0;

void expect(bool holds, const char* what) {
  std::printf("%s %s\n", holds ? "ok    " : "FAILED", what);
  failures += holds ? 0 : 1;
}

/// On hardware `wait` returns at that time; here it is what the samples of the converters have come to.
void check_conformance(std::int32_t period_ns) {
  InverterRegisters registers{};
  registers.u_dc = 21'200;
  RegisterDriveIo io{registers, period_ns};
  const auto wait = [&](std::int64_t t_ns) { registers.period_count = std::uint32_t(t_ns / period_ns); };
  const sextant::ConformanceResult result = sextant::check_drive_io<double>(
      io, {.period_ns = period_ns, .actuation_delay_periods = 1, .has_machine = false, .wait = wait});
  expect(sextant::report("RegisterDriveIo", result) == 0, "it is what a drive relies on");
}

}  // namespace

int main() {
  constexpr std::int32_t period_ns = 25'000;
  check_conformance(period_ns);
  InverterRegisters registers{};
  registers.u_dc = 21'200;  // 530 V

  RegisterDriveIo io{registers, period_ns};
  // The drive: machine (the paper's here), link and inverter, said once. What is not given, as the trip
  // levels, follows from them.
  sextant::DriveSetup<double> setup;
  setup.basis.period_ns = period_ns;
  setup.basis.actuation_delay_periods = 1;
  setup.basis.u_dc = 530.0;
  setup.command.torque_limit = 150.0;
  expect(setup.validate() == nullptr, "the setup is usable");
  const sextant::ResolvedDrive<double> resolved = sextant::resolved(setup);
  expect(resolved.validate() == nullptr, "what follows from it too");
  using Controller = sextant::DirectTorqueController<double>;
  Controller controller{sextant::default_parameters<Controller>(resolved.control)};
  sextant::Drive<double> drive{resolved.drive, controller};
  Commands commands;
  LastTelemetry telemetry;
  std::int64_t t_ns = 0;
  const auto run = [&](int periods) {
    for (int n = 0; n < periods; ++n) {
      registers.period_count = registers.period_count + 1;
      sextant::run_cycle(t_ns += period_ns, io, commands, drive, telemetry);
    }
  };

  run(30);
  expect(drive.state() == sextant::DriveState::ready && registers.gates[0] == 0, "ready, with its gates off");
  expect(telemetry.last.u_dc == 530.0, "values are scaled");
  run(12);  // currents that stay zero for longer are those of converters that have stopped
  expect(drive.state() == sextant::DriveState::magnetising && registers.gates[0] != 0,
         "enabled, a pattern is applied");
  std::uint32_t ticks = 0;
  for (std::uint32_t n = 0; n < registers.segment_count; ++n) ticks += registers.ticks[n];
  expect(ticks == 2'500, "for the whole period");
  expect(registers.watchdog == 42, "the hardware's watchdog is served once a period");
  registers.fault = 1;
  run(1);
  expect(drive.state() == sextant::DriveState::fault && registers.gates[0] == 0,
         "a fault turns the gates off in its period");
  return failures == 0 ? 0 : 1;
}
