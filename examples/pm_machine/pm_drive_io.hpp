#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "pm_machine.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace example {

/// The simulated power stage: inverter and machine at an imposed speed, moved by the patterns of the drive.
class PmDriveIo final : public sextant::DriveIo<double> {
 public:
  using Plant = sextant::DrivePlant<double, sextant::NoAppendedSystem<double>, PmMachine<double>>;

  PmDriveIo(const PmParameters<double>& machine, double u_dc, double omega_m)
      : plant_{parameters_of(machine, omega_m), {}, PmMachine<double>{machine}} {
    sextant::PlantInputs<double> inputs;
    inputs.state = sextant::gates_off;
    inputs.u_dc = u_dc;
    inputs.imposed_speed = true;
    plant_.set_inputs(inputs);
  }

  [[nodiscard]] sextant::Measurement<double> read(std::int64_t) noexcept SEXTANT_NONBLOCKING override {
    const bool healthy = integrator_.advance_through(plant_, applied_.segments(), {});
    return {.i_abc = plant_.i_abc(),
            .u_dc = plant_.u_dc(),
            .omega_m = plant_.omega_m(),
            .applied = applied_,
            .plausible = healthy && plant_.is_reachable(),
            .theta_m = std::remainder(plant_.theta_m(), 2.0 * std::numbers::pi)};
  }
  void write(const sextant::GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    applied_ = pattern;
  }

  [[nodiscard]] const Plant& plant() const noexcept { return plant_; }

 private:
  [[nodiscard]] static sextant::DrivePlantParameters<double> parameters_of(
      const PmParameters<double>& machine, double omega_m) {
    sextant::DrivePlantParameters<double> p;
    p.machine.inertia = machine.inertia;
    p.initial = {.speed = omega_m, .rotor_flux = machine.psi_m};
    return p;
  }

  Plant plant_;
  sextant::FixedStepIntegrator<Plant> integrator_{};
  sextant::GatePattern applied_{};
};

}  // namespace example
