// Golden inputs under QEMU: the answers of the drive and of the plant, and what each step cost in
// instructions. Arguments (semihosting): golden INPUTS OUTPUTS COSTS.
#include "arguments.hpp"
#include "cortex_m/golden/golden_record.hpp"
#include "cortex_m/golden/plant_replay.hpp"
#include "report_stack.hpp"
#include "semihosting.hpp"
#include "startup.hpp"
#include "stopwatch.hpp"
#include "sys_tick.hpp"

namespace sextant::golden {
namespace {

using semihosting::File;
using semihosting::Mode;

/// Ticks of calls that do nothing, and that execute 1000 and 2000 instructions: how the checker knows that it
/// counts instructions.
struct Calibration {
  std::uint32_t nothing{};
  std::uint32_t thousand{};
  std::uint32_t two_thousand{};
};

// Calls that the compiler neither sees through nor moves, so that each measurement holds the whole step.
[[gnu::noipa]] void do_nothing() {}
[[gnu::noipa]] void do_thousand() {
  asm volatile(".rept 1000\n nop\n .endr");
}
[[gnu::noipa]] void do_two_thousand() {
  asm volatile(".rept 2000\n nop\n .endr");
}
[[gnu::noipa]] DriveOutput<float> step_drive(Drive<float>& drive, const Input& input) {
  return drive.step(input.t_ns, input.measurement, input.request);
}
[[gnu::noipa]] GatePattern step_controller(DirectTorqueController<float>& controller,
                                           const Measurement<float>& measurement,
                                           ControlReference<float> reference) {
  return controller.step(measurement, reference);
}
[[gnu::noipa]] bool step_plant(PlantReplay<float>& plant, const Measurement<float>& measurement) {
  return plant.step(measurement);
}

/// Hands every step on to a controller and notes what it took.
class MeasuredController final : public Controller<float> {
 public:
  explicit MeasuredController(const DirectTorqueController<float>::Parameters& parameters)
      : inner_{parameters} {}
  GatePattern step(const Measurement<float>& measurement,
                   ControlReference<float> reference) noexcept SEXTANT_NONBLOCKING override {
    Stopwatch watch;
    watch.start();
    const GatePattern pattern = step_controller(inner_, measurement, reference);
    ticks = watch.ticks();
    estimate_ = inner_.estimate();
    return pattern;
  }
  void restart() noexcept SEXTANT_NONBLOCKING override {
    inner_.restart();
    estimate_ = inner_.estimate();
  }
  void reset() noexcept SEXTANT_NONBLOCKING override {
    inner_.reset();
    estimate_ = inner_.estimate();
  }
  [[nodiscard]] bool holds_mean_torque() const noexcept override { return inner_.holds_mean_torque(); }

  std::uint32_t ticks{};

 private:
  DirectTorqueController<float> inner_;
};

[[gnu::noipa]] std::uint32_t ticks_of(void (*work)()) {
  Stopwatch watch;
  watch.start();
  work();
  return watch.ticks();
}

[[nodiscard]] Calibration calibrate() {
  return {ticks_of(do_nothing), ticks_of(do_thousand), ticks_of(do_two_thousand)};
}

[[nodiscard]] bool replay(const Setup& setup, File& inputs, File& outputs, File& costs) {
  // Statically, as firmware has them.
  static DirectTorqueController<float> controller{controller_parameters<float>(setup)};
  static Drive<float> drive{drive_parameters<float>(setup), controller};
  static MeasuredController measured{controller_parameters<float>(setup)};
  static Drive<float> drive_of_measured{drive_parameters<float>(setup), measured};
  static PlantReplay<float> plant;
  Stopwatch watch;
  for (std::uint32_t k = 0; k < setup.periods; ++k) {
    static Input input;
    if (!inputs.read(&input, sizeof input)) return false;
    Cost cost;
    watch.start();
    const DriveOutput<float> answer = step_drive(drive, input);
    cost.drive = watch.ticks();
#ifdef SEXTANT_DRIVE_ONLY  // for a trace of every instruction, which is long
    continue;
#endif
    measured.ticks = 0;
    [[maybe_unused]] const DriveOutput<float> same_answer = step_drive(drive_of_measured, input);
    cost.controller = measured.ticks;
    watch.start();
    if (!step_plant(plant, input.measurement)) return false;
    cost.plant = watch.ticks();
    cost.driven = input.measurement.applied.is_driven() ? 1 : 0;
    const Output output = output_of(answer);
    const PlantOutput plant_output = plant.output();
    if (!outputs.write(&output, sizeof output) || !outputs.write(&plant_output, sizeof plant_output) ||
        !costs.write(&cost, sizeof cost)) {
      return false;
    }
  }
  return true;
}

[[nodiscard]] const char* run() {
  static Arguments<3> arguments;
  if (!arguments.read()) return "golden: INPUTS OUTPUTS COSTS are expected\n";
  File inputs{arguments.names[0], Mode::read};
  File outputs{arguments.names[1], Mode::write};
  File costs{arguments.names[2], Mode::write};
  if (!inputs.is_open() || !outputs.is_open() || !costs.is_open()) return "golden: a file cannot be opened\n";
  Setup setup;
  if (!inputs.read(&setup, sizeof setup) || setup.input_size != sizeof(Input)) {
    return "golden: these are no golden inputs, or the host lays them out differently\n";
  }
  SysTick::instance().start(SysTick::mask, false);
  const Calibration calibration = calibrate();
  if (!costs.write(&calibration, sizeof calibration)) return "golden: cannot write the costs\n";
  return replay(setup, inputs, outputs, costs) ? nullptr : "golden: the replay failed\n";
}

}  // namespace
}  // namespace sextant::golden

void run_firmware() {
  const char* problem = sextant::golden::run();
  if (problem != nullptr) semihosting::print(problem);
  report_stack();
  semihosting::exit(problem == nullptr);
}
