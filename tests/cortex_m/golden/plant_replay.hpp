#pragma once

#include "cortex_m/golden/golden_record.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant::golden {

/// The plant of a golden run, moved by the applied patterns; its currents are not fed back to a drive.
template <class T>
class PlantReplay {
 public:
  /// Brings the plant to the instant of the measurement; false when the integration failed.
  [[nodiscard]] bool step(const Measurement<float>& measurement) noexcept {
    for (const GateSegment& segment : measurement.applied.segments()) {
      plant_.set_inputs({segment.state, u_dc, load_torque<T>, false, T(0)});
      if (!integrator_.advance(plant_, segment.duration_ns)) return false;
    }
    return true;
  }

  [[nodiscard]] PlantOutput output() const noexcept {
    const SpaceVector<T> i_s = plant_.i_s();
    return {float(i_s.alpha), float(i_s.beta), float(plant_.tau_e()), float(plant_.omega_m())};
  }

 private:
  static constexpr T u_dc = T(530);  // [V]
  DrivePlant<T> plant_{plant_parameters<T>()};
  FixedStepIntegrator<DrivePlant<T>> integrator_{};
};

}  // namespace sextant::golden
