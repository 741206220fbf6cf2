// The least firmware of a drive: one cycle a tick, over registers. A board adds its clock tree, pins, dead
// time and the start of its converters, and fills the mailbox from its CAN interrupt.
#include <utility>

#include "register_drive_io.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/resolved.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "startup.hpp"
#include "sys_tick.hpp"
#ifdef SEXTANT_STOP_AFTER_PERIODS
#include "report_stack.hpp"
#include "semihosting.hpp"
#endif

namespace sextant::firmware {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr std::uint32_t clocks_per_period = 4'200;  // at 168 MHz

/// Where the CAN interrupt puts what it received and the drive finds it.
struct Mailbox {
  TorqueCommand<float> command{};
  DriveRequest<float> latest(std::int64_t) noexcept {
    DriveRequest<float> request;
    asm volatile("cpsid i" ::: "memory");  // the interrupt that writes is short: no copy is torn
    request.command = command;
    asm volatile("cpsie i" ::: "memory");
    return request;
  }
};

/// The newest record, for a debugger or a status message.
struct NewestTelemetry {
  Telemetry<float> value{};
  void push(const Telemetry<float>& telemetry) noexcept { value = telemetry; }
};

/// The paper's machine at 530 V; every limit follows from it.
ResolvedDrive<float> resolved_drive() {
  DriveSetup<float> setup;
  setup.basis.period_ns = period_ns;
  setup.basis.actuation_delay_periods = 1;
  return resolved(setup);
}

Mailbox mailbox;
NewestTelemetry telemetry;
RegisterDriveIo io{RegisterDriveIo::Parameters{}};
DirectTorqueController<float> controller{
    default_parameters<DirectTorqueController<float>>(resolved_drive().control)};
Drive<float> drive{resolved_drive().drive, controller};
std::int64_t t_ns = 0;

}  // namespace
}  // namespace sextant::firmware

extern "C" void sys_tick_handler() {
  using namespace sextant::firmware;
  run_cycle(t_ns, io, mailbox, drive, telemetry);
  t_ns += period_ns;
}

void run_firmware() {
  using namespace sextant::firmware;
  SysTick::instance().start(clocks_per_period - 1, true);
#ifdef SEXTANT_STOP_AFTER_PERIODS
  // Without a board the converters read nothing: the drive must have noticed, and its gates must be off.
  while (*static_cast<volatile std::int64_t*>(&t_ns) < std::int64_t{SEXTANT_STOP_AFTER_PERIODS} * period_ns) {
    asm volatile("wfi");
  }
  SysTick::instance().control = 0;
  report_stack();
  semihosting::exit(drive.state() == sextant::DriveState::fault &&
                    !is_driven(telemetry.value.pattern.last_state()));
#else
  for (;;) asm volatile("wfi");
#endif
}
