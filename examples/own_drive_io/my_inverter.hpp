// The power stage of an inverter of your own, for sextant-ecu: power_stage = "my_inverter". Beside it: the
// program (main.cpp), the conformance test (conformance.cpp), a configuration (ecu.toml), a profile of torque
// (torque.csv) and the project (CMakeLists.txt). board.hpp stands in for the hardware.
#pragma once

#include "board.hpp"
#include "sextant/core/description.hpp"
#include "sextant/core/drive_basis.hpp"
#include "sextant/core/supervised_drive_io.hpp"

namespace example {

/// A `DriveIo` is enough; a `SupervisedDriveIo` also has what the other threads ask for, as a line that turns
/// the gates off.
class MyInverter final : public sextant::SupervisedDriveIo<double> {
 public:
  static constexpr const char* name = "my_inverter";
  static constexpr const char* meaning = "the board of the example";
  /// The board of this example waits, as a model does. Leave it out for hardware.
  static constexpr bool waits_for_drive = true;

  struct Parameters {
    sextant::DriveBasis<double> basis{};  ///< machine, period and delay of the drive
    // Keys of [my_inverter].
    double current_step{12.5e-3};  ///< of the converters of the currents [A]
    double voltage_step{25e-3};    ///< of that of the link voltage [V]

    void set_basis(const sextant::DriveBasis<double>& of_drive) noexcept { basis = of_drive; }
    [[nodiscard]] const char* validate() const noexcept {
      return basis.u_dc > 65'535 * voltage_step ? "the link voltage is beyond the converter's range"
                                                : nullptr;
    }
  };

  /// Opens the hardware. Throws std::runtime_error with one sentence where it is not there.
  explicit MyInverter(const Parameters& p) : p_{p}, board_{p.basis, p.current_step, p.voltage_step} {}

  [[nodiscard]] sextant::Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    const Board::Sample sample = board_.sample(t_ns);
    sextant::Measurement<double> m;
    m.i_abc = {p_.current_step * sample.i_a, p_.current_step * sample.i_b, p_.current_step * sample.i_c};
    m.u_dc = p_.voltage_step * sample.u_dc;
    m.omega_m = Board::speed_step * sample.speed;
    m.applied = sample.applied;
    m.plausible = sample.is_healthy;
    return m;
  }

  void write(const sextant::GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    board_.set(pattern);
  }

  /// The gate-enable line of the hardware; this board has none.
  void inhibit_gates() noexcept override {}

 private:
  Parameters p_;
  Board board_;
};

inline void describe(sextant::Description& d, MyInverter::Parameters& p) {
  auto& [basis, current_step, voltage_step] = p;
  d.number("current_step_a", current_step, {"A", 1e-6, 1, "step of the converters of the currents"});
  d.number("voltage_step_v", voltage_step, {"V", 1e-6, 1, "step of the converter of the link voltage"});
}

}  // namespace example
