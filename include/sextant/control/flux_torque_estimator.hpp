#pragma once

#include <algorithm>
#include <cstdint>

#include "sextant/control/current_model.hpp"
#include "sextant/control/voltage_model.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant {

/// Torque of the machine, T_e = 3/2 p ψ_s × i_s. [N·m]
template <class T>
[[nodiscard]] constexpr T electromagnetic_torque(int pole_pairs, SpaceVector<T> psi_s,
                                                 SpaceVector<T> i_s) noexcept {
  return T(1.5) * T(pole_pairs) * cross(psi_s, i_s);
}

/// Torque and flux estimator (paper, 2.2.1): the voltage model while the gates are driven. While they are
/// off the current model continues the flux, so that a drive can be enabled again on a spinning machine that
/// still has rotor flux, also after a gap of many periods. Each model starts from the other's result.
template <class T = double>
class FluxTorqueEstimator {
 public:
  constexpr explicit FluxTorqueEstimator(const InductionMachineParameters<T>& machine) noexcept
      : voltage_model_{machine.r_s},
        current_model_{machine},
        sigma_l_s_{machine.sigma_l_s()},
        torque_gain_{T(1.5) * T(machine.pole_pairs)} {}

  /// Updates the estimate by the measurement at the end of a period and its applied pattern.
  void step(const Measurement<T>& measurement) noexcept {
    const SpaceVector<T> i_s_before = i_s_;
    i_s_ = clarke(measurement.i_abc);
    if (measurement.applied.is_driven()) {
      coasting_ = false;
      voltage_model_.step(measurement.applied, measurement.u_dc, i_s_before, i_s_);
    } else {
      step_coasting(measurement, i_s_before);
    }
    omega_m_ = measurement.omega_m;
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_s() const noexcept { return voltage_model_.psi_s(); }  ///< [Wb]
  [[nodiscard]] constexpr SpaceVector<T> i_s() const noexcept { return i_s_; }                      ///< [A]
  [[nodiscard]] constexpr T torque() const noexcept {
    return torque_gain_ * cross(psi_s(), i_s_);  // [N·m]
  }

  [[nodiscard]] constexpr const VoltageModel<T>& voltage_model() const noexcept { return voltage_model_; }
  [[nodiscard]] constexpr const CurrentModel<T>& current_model() const noexcept { return current_model_; }

  /// Sets the flux to zero, as after power-up.
  constexpr void reset() noexcept {
    voltage_model_.set({});
    current_model_.set({});
    i_s_ = {};
    omega_m_ = T(0);
    coasting_ = true;
  }

 private:
  void step_coasting(const Measurement<T>& measurement, SpaceVector<T> i_s_before) noexcept {
    if (!coasting_) current_model_.set(current_model_.psi_r_from(psi_s(), i_s_before));
    coasting_ = true;
    const T dt = T(measurement.applied.duration_ns()) * T(1e-9);
    const T omega_m = T(0.5) * (omega_m_ + measurement.omega_m);
    const T decay =
        std::min(dt, driven_time(measurement.applied) + decay_time(measurement.u_dc, i_s_before, dt));
    if (decay > T(0)) current_model_.step(T(0.5) * (i_s_before + i_s_), omega_m, decay);
    if (decay < dt) current_model_.step(i_s_, omega_m, dt - decay);
    voltage_model_.set(current_model_.psi_s(i_s_));
  }

  /// Decay time of the current of the last measurement after the gates turned off, at most dt: the diodes
  /// apply about 2/3 u_dc against it. After that time the measured current flows. dt without link voltage.
  /// [s]
  [[nodiscard]] T decay_time(T u_dc, SpaceVector<T> i_s_before, T dt) const noexcept {
    const T volt_seconds = T(1.5) * sigma_l_s_ * magnitude(i_s_before);
    return volt_seconds < u_dc * dt ? volt_seconds / u_dc : dt;
  }

  /// Time until the first leg is off. [s]
  [[nodiscard]] static constexpr T driven_time(const GatePattern& applied) noexcept {
    std::int64_t t_ns = 0;
    for (const GateSegment& segment : applied.segments()) {
      if (!is_driven(segment.state)) break;
      t_ns += segment.duration_ns;
    }
    return T(t_ns) * T(1e-9);
  }

  VoltageModel<T> voltage_model_;
  CurrentModel<T> current_model_;
  T sigma_l_s_;
  T torque_gain_;         ///< 3/2 p [-]
  SpaceVector<T> i_s_{};  ///< at the last measurement [A]
  T omega_m_{};           ///< at the last measurement [rad/s]
  bool coasting_{true};
};

}  // namespace sextant
