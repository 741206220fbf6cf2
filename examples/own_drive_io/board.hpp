// Stands in for the hardware: the paper's machine behind converters of 16 bits. Yours is the real one, behind
// registers or a bus, and this file falls away.
#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/drive_basis.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace example {

class Board {
 public:
  static constexpr double speed_step = 1e-3;  ///< of the encoder [rad/s]

  /// What the board has sampled at the beginning of a control period.
  struct Sample {
    std::int16_t i_a, i_b, i_c;    ///< phase currents [steps]
    std::uint16_t u_dc;            ///< [steps]
    std::int32_t speed;            ///< [speed_step]
    sextant::GatePattern applied;  ///< since the sample before
    bool is_healthy;
  };

  /// Steps of its converters: current [A], voltage [V].
  Board(const sextant::DriveBasis<double>& basis, double current_step, double voltage_step)
      : current_step_{current_step}, voltage_step_{voltage_step}, stage_{parameters(basis), {}} {}

  [[nodiscard]] Sample sample(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    const sextant::Measurement<double> m = stage_.io().read(t_ns);
    const auto current = [this](double i) { return std::int16_t(std::lround(i / current_step_)); };
    return {current(m.i_abc.a),
            current(m.i_abc.b),
            current(m.i_abc.c),
            std::uint16_t(std::lround(m.u_dc / voltage_step_)),
            std::int32_t(std::lround(m.omega_m / speed_step)),
            m.applied,
            m.plausible};
  }

  void set(const sextant::GatePattern& pattern) noexcept SEXTANT_NONBLOCKING { stage_.io().write(pattern); }

 private:
  static sextant::SimulatedPowerStage::Parameters parameters(const sextant::DriveBasis<double>& basis) {
    sextant::SimulatedPowerStage::Parameters p;
    p.plant.machine = basis.machine;
    p.io.period_ns = basis.period_ns;
    p.io.actuation_delay_periods = basis.actuation_delay_periods;
    p.io.u_dc = basis.u_dc;
    p.integrator = sextant::IntegratorKind::fixed;
    return p;
  }

  double current_step_;
  double voltage_step_;
  sextant::SimulatedPowerStage stage_;
};

}  // namespace example
