// What a step of each control method costs in instructions, on the measurements of golden inputs. Prints the
// names of the methods. Arguments (semihosting): methods INPUTS COSTS.
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "arguments.hpp"
#include "cortex_m/golden/golden_record.hpp"
#include "semihosting.hpp"
#include "sextant/control/controller_list.hpp"
#include "startup.hpp"
#include "stopwatch.hpp"
#include "sys_tick.hpp"

namespace sextant::golden {
namespace {

using semihosting::File;
using semihosting::Mode;

[[gnu::noipa]] GatePattern step(Controller<float>& controller, const Measurement<float>& measurement,
                                ControlReference<float> reference) {
  return controller.step(measurement, reference);
}

template <class C>
[[nodiscard]] typename C::Parameters parameters(const Setup& setup) {
  typename C::Parameters p;
  p.period_ns = setup.period_ns;
  p.actuation_delay_periods = setup.actuation_delay_periods;
  return p;
}

template <class C>
void print_name() {
  semihosting::print(C::name);
  semihosting::print("\n");
}

template <class... C>
[[nodiscard]] bool replay(std::tuple<C...>* /*list*/, const Setup& setup, File& inputs, File& costs) {
  (print_name<C>(), ...);
  static std::tuple<C...> controllers{parameters<C>(setup)...};
  static const std::array<Controller<float>*, sizeof...(C)> list = std::apply(
      [](auto&... controller) { return std::array<Controller<float>*, sizeof...(C)>{&controller...}; },
      controllers);
  Stopwatch watch;
  for (std::uint32_t k = 0; k < setup.periods; ++k) {
    static Input input;
    if (!inputs.read(&input, sizeof input)) return false;
    const bool driven = input.measurement.applied.is_driven();
    const ControlReference<float> reference{driven ? ControlMode::torque : ControlMode::off,
                                            input.request.command.torque, 1.0F};
    for (Controller<float>* controller : list) {
      watch.start();
      (void)step(*controller, input.measurement, reference);
      const std::uint32_t cost = driven ? watch.ticks() : 0;
      if (!costs.write(&cost, sizeof cost)) return false;
    }
  }
  return true;
}

[[nodiscard]] const char* run() {
  static Arguments<2> arguments;
  if (!arguments.read()) return "methods: INPUTS COSTS are expected\n";
  File inputs{arguments.names[0], Mode::read};
  File costs{arguments.names[1], Mode::write};
  if (!inputs.is_open() || !costs.is_open()) return "methods: a file cannot be opened\n";
  Setup setup;
  if (!inputs.read(&setup, sizeof setup) || setup.input_size != sizeof(Input)) {
    return "methods: these are no golden inputs, or the host lays them out differently\n";
  }
  SysTick::instance().start(SysTick::mask, false);
  return replay(static_cast<ControllerList<float>*>(nullptr), setup, inputs, costs)
             ? nullptr
             : "methods: the replay failed\n";
}

}  // namespace
}  // namespace sextant::golden

void run_firmware() {
  const char* problem = sextant::golden::run();
  if (problem != nullptr) semihosting::print(problem);
  semihosting::exit(problem == nullptr);
}
