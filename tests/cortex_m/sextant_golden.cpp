// sextant_golden: records a closed-loop run of the drive in `float`, and replays it, in `float` or `double`.
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/command_line.hpp"
#include "common/program.hpp"
#include "cortex_m/golden/golden_record.hpp"
#include "cortex_m/golden/plant_replay.hpp"
#include "cortex_m/golden/vehicle.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant::golden {
namespace {

template <class T>
[[nodiscard]] Measurement<T> converted(const auto& m) {
  return {.i_abc = {T(m.i_abc.a), T(m.i_abc.b), T(m.i_abc.c)},
          .u_dc = T(m.u_dc),
          .omega_m = T(m.omega_m),
          .applied = m.applied,
          .plausible = m.plausible};
}

template <class T>
[[nodiscard]] DriveRequest<T> converted(const DriveRequest<float>& r) {
  const TorqueCommand<float>& c = r.command;
  return {.command = {.torque = T(c.torque),
                      .torque_limit = T(c.torque_limit),
                      .enable = c.enable,
                      .fault_reset = c.fault_reset,
                      .received_ns = c.received_ns,
                      .sequence = c.sequence,
                      .disables = c.disables,
                      .resets = c.resets,
                      .rejected = c.rejected,
                      .counter = c.counter,
                      .e2e = c.e2e,
                      .out_of_range = c.out_of_range,
                      .bus_off = c.bus_off},
          .shutdown = r.shutdown,
          .external = r.external};
}

/// The simulated power stage as a microcontroller sees it, and what it saw last.
class FloatIo final : public DriveIo<float> {
 public:
  explicit FloatIo(DriveIo<double>& inner) : inner_{inner} {}
  Measurement<float> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    last_ = converted<float>(inner_.read(t_ns));
    if (t_ns == bad_sensor_ms * 1'000'000LL) last_.i_abc.a = std::numeric_limits<float>::quiet_NaN();
    return last_;
  }
  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override { inner_.write(pattern); }
  [[nodiscard]] const Measurement<float>& last() const { return last_; }

 private:
  DriveIo<double>& inner_;
  Measurement<float> last_{};
};

struct Vehicle {
  DriveRequest<float> last{};
  DriveRequest<float> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    return last = request_at(t_ns);
  }
};

struct NoTelemetry {
  void push(const Telemetry<float>&) noexcept SEXTANT_NONBLOCKING {}
};

[[nodiscard]] std::vector<Input> record(const Setup& setup) {
  SimulatedPowerStage::Parameters stage_parameters;
  stage_parameters.plant = plant_parameters<double>();
  stage_parameters.integrator = IntegratorKind::fixed;
  stage_parameters.io.period_ns = setup.period_ns;
  stage_parameters.io.actuation_delay_periods = setup.actuation_delay_periods;
  MechanicalLoad::Parameters load;
  load.load_torque.value = load_torque<double>;
  SimulatedPowerStage stage{stage_parameters, load};
  FloatIo io{stage.io()};
  DirectTorqueController<float> controller{controller_parameters<float>(setup)};
  Drive<float> drive{drive_parameters<float>(setup), controller};
  Vehicle vehicle;
  NoTelemetry telemetry;
  std::vector<Input> inputs;
  for (std::int64_t t_ns = 0; t_ns < end_ms * 1'000'000LL; t_ns += setup.period_ns) {
    run_cycle(t_ns, io, vehicle, drive, telemetry);
    inputs.push_back({t_ns, io.last(), vehicle.last});
    for (const Late& l : late) {
      if (t_ns == l.at_ms * 1'000'000LL) t_ns += std::int64_t{l.periods} * setup.period_ns;
    }
  }
  return inputs;
}

template <class Value>
void write(std::ofstream& file, const Value* values, std::size_t count) {
  file.write(reinterpret_cast<const char*>(values), std::streamsize(count * sizeof(Value)));
}

void save(const std::string& name, Setup setup, const std::vector<Input>& inputs) {
  std::ofstream file{name, std::ios::binary};
  setup.input_size = sizeof(Input);
  setup.periods = std::uint32_t(inputs.size());
  write(file, &setup, 1);
  write(file, inputs.data(), inputs.size());
  file.flush();
  if (!file) throw std::runtime_error{"cannot write \"" + name + "\""};
}

[[nodiscard]] std::vector<Input> load(const std::string& name, Setup& setup) {
  std::ifstream file{name, std::ios::binary};
  file.read(reinterpret_cast<char*>(&setup), sizeof setup);
  if (!file || setup.input_size != sizeof(Input)) {
    throw std::runtime_error{"\"" + name + "\" is no file of golden inputs; \"record\" makes one"};
  }
  std::vector<Input> inputs(setup.periods);
  file.read(reinterpret_cast<char*>(inputs.data()), std::streamsize(inputs.size() * sizeof(Input)));
  if (!file) throw std::runtime_error{"\"" + name + "\" ends early; \"record\" makes it anew"};
  return inputs;
}

/// By how much a replay moves what the controller compares with: tells which decisions hang on rounding.
struct Shifts {
  double torque{0};      ///< of the torque reference [N·m]
  double flux{0};        ///< of the reference [Wb]
  double sector_deg{0};  ///< of the sectors [°]
  double current{0};     ///< of the magnetiser's levels [A]
};

template <class T>
[[nodiscard]] typename DirectTorqueController<T>::Parameters shifted(const Setup& setup, const Shifts& by) {
  typename DirectTorqueController<T>::Parameters p = controller_parameters<T>(setup);
  p.flux_reference += T(by.flux);
  p.sector.sector_start_deg += T(by.sector_deg);
  p.magnetiser.current_limit += T(by.current);
  p.magnetiser.hand_over_current += T(by.current);
  return p;
}

/// The controller with another torque reference.
template <class T>
class ShiftedTorque final : public Controller<T> {
 public:
  ShiftedTorque(Controller<T>& inner, T by) : inner_{inner}, by_{by} {}
  GatePattern step(const Measurement<T>& measurement,
                   ControlReference<T> reference) noexcept SEXTANT_NONBLOCKING override {
    const GatePattern pattern =
        inner_.step(measurement, {reference.mode, reference.torque + by_, reference.flux_share});
    this->estimate_ = inner_.estimate();
    return pattern;
  }
  void restart() noexcept SEXTANT_NONBLOCKING override {
    inner_.restart();
    this->estimate_ = inner_.estimate();
  }
  void reset() noexcept SEXTANT_NONBLOCKING override {
    inner_.reset();
    this->estimate_ = inner_.estimate();
  }
  [[nodiscard]] bool holds_mean_torque() const noexcept override { return inner_.holds_mean_torque(); }

 private:
  Controller<T>& inner_;
  T by_;
};

template <class T>
void replay(const std::string& from, const std::string& to, const Shifts& shifts) {
  Setup setup;
  const std::vector<Input> inputs = load(from, setup);
  DirectTorqueController<T> controller{shifted<T>(setup, shifts)};
  ShiftedTorque<T> shifted_controller{controller, T(shifts.torque)};
  Drive<T> drive{drive_parameters<T>(setup), shifted_controller};
  PlantReplay<T> plant;
  std::ofstream file{to, std::ios::binary};
  for (const Input& input : inputs) {
    const Output output =
        output_of(drive.step(input.t_ns, converted<T>(input.measurement), converted<T>(input.request)));
    if (!plant.step(input.measurement)) throw std::runtime_error{"the integration of the plant failed"};
    const PlantOutput plant_output = plant.output();
    write(file, &output, 1);
    write(file, &plant_output, 1);
  }
  file.flush();
  if (!file) throw std::runtime_error{"cannot write \"" + to + "\""};
}

struct Options {
  std::string inputs{};
  std::string outputs{};
  std::string scalar{"float"};
  Setup setup{};
  Shifts shifts{};
};

CommandLine command_line(Options& options) {
  const auto shift = [](const char* name, double& value, const char* what) {
    return Option{.name = name, .value = &value, .what = what, .needs = "outputs"};
  };
  return {"sextant_golden",
          "Records a closed-loop run of the drive in float, or replays its inputs.",
          "Without outputs it writes the inputs, with them it reads the inputs and writes the answers.",
          {{.name = "inputs", .value = &options.inputs, .what = "what the drive gets", .required = true},
           {.name = "outputs", .value = &options.outputs, .what = "the answers of a replay"},
           {.name = "--delay",
            .value = &options.setup.actuation_delay_periods,
            .what = "actuation delay of the run that is recorded [periods]",
            .excludes = {"outputs"},
            .least = 0,
            .most = 1},
           {.name = "--scalar",
            .value = &options.scalar,
            .what = "arithmetic of the replay",
            .needs = "outputs",
            .choices = {"float", "double"}},
           shift("--shift-torque", options.shifts.torque, "added to the torque reference [N·m]"),
           shift("--shift-flux", options.shifts.flux, "added to the flux reference [Wb]"),
           shift("--shift-sector", options.shifts.sector_deg, "added to the sectors' start [°]"),
           shift("--shift-current", options.shifts.current, "added to the magnetiser's current levels [A]")}};
}

int run(const Options& options) {
  if (options.outputs.empty()) {
    save(options.inputs, options.setup, record(options.setup));
  } else if (options.scalar == "float") {
    replay<float>(options.inputs, options.outputs, options.shifts);
  } else {
    replay<double>(options.inputs, options.outputs, options.shifts);
  }
  return 0;
}

}  // namespace
}  // namespace sextant::golden

int main(int argc, char** argv) {
  sextant::golden::Options options;
  const sextant::CommandLine line = sextant::golden::command_line(options);
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return sextant::run_program(line.program, [&] { return sextant::golden::run(options); });
}
