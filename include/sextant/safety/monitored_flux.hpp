#pragma once

#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Rotor flux of the torque monitor, from currents and speed, stationary frame:
///   dψ_r/dt = (−1/τ_r + j p ω_m) ψ_r + (L_m/τ_r) i_s
/// It needs neither R_s nor a voltage, and holds with gates on and off. Source: P. Vas, Sensorless Vector and
/// Direct Torque Control, Oxford 1998. The estimators of `control` hold the same equation; this
/// is a second formulation on purpose, so that no error of theirs, in code, parameters or state, is also one
/// of the monitor.
///
/// A step shrinks and turns ψ_r exactly and adds half of the current's part before the turn, half after it:
/// exact without current, in steps of any length, else to order (p ω_m dt)².
template <class T = double>
class MonitoredFlux {
 public:
  constexpr explicit MonitoredFlux(const InductionMachineParameters<T>& machine) noexcept
      : pole_pairs_{T(machine.pole_pairs)} {
    set_machine(machine);
  }

  /// R_r and inductances from here on; the flux stays.
  constexpr void set_machine(const InductionMachineParameters<T>& machine) noexcept {
    inverse_tau_r_ = T(1) / machine.tau_r();
    l_m_ = machine.l_m;
  }

  /// Advances by dt [s] with the mean current [A] and mechanical speed [rad/s] of that time.
  void step(SpaceVector<T> i_s, T omega_m, T dt) noexcept {
    const T turn = pole_pairs_ * omega_m * dt;
    const T decay = dt * inverse_tau_r_;
    SpaceVector<T> direction;
    T lost{};  // share of the flux
    // The series err by less than 4e-7 of the flux.
    if (std::abs(turn) < T(0.25) && decay < T(0.05)) {
      const T square = turn * turn;
      direction = {T(1) - square * (T(0.5) - square * T(1.0 / 24.0)),
                   turn * (T(1) - square * (T(1.0 / 6.0) - square * T(1.0 / 120.0)))};
      lost = decay * (T(1) - decay * (T(0.5) - decay * T(1.0 / 6.0)));
    } else {
      direction = {std::cos(turn), std::sin(turn)};
      lost = -std::expm1(-decay);
    }
    const SpaceVector<T> half = (T(0.5) * lost * l_m_) * i_s;
    const SpaceVector<T> before = (T(1) - lost) * psi_r_ + half;
    psi_r_ = direction.alpha * before + direction.beta * rotate_90(before) + half;
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_r() const noexcept { return psi_r_; }  ///< [Wb]

 private:
  T inverse_tau_r_{};
  T l_m_{};
  T pole_pairs_;
  SpaceVector<T> psi_r_{};
};

}  // namespace sextant
