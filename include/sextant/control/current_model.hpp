#pragma once

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Current model of the rotor flux in the stationary frame,
///   dψ_r/dt = −ψ_r/τ_r + j p ω_m ψ_r + (L_m/τ_r) i_s,   ψ_s = k_r ψ_r + σL_s i_s.
/// It needs the speed but no voltage, and it is stable: it carries the flux while the gates are off, when
/// diodes and EMF rather than the gate pattern decide the voltage.
/// Source: P. Vas, Sensorless Vector and Direct Torque Control, Oxford 1998, section 4.1.
template <class T = double>
class CurrentModel {
 public:
  constexpr explicit CurrentModel(const InductionMachineParameters<T>& machine) noexcept
      : inverse_tau_r_{T(1) / machine.tau_r()},
        l_m_{machine.l_m},
        k_r_{machine.k_r()},
        sigma_l_s_{machine.sigma_l_s()},
        pole_pairs_{T(machine.pole_pairs)} {}

  /// dψ_r/dt. [V]
  [[nodiscard]] constexpr SpaceVector<T> derivative(SpaceVector<T> psi_r, SpaceVector<T> i_s,
                                                    T omega_m) const noexcept {
    return inverse_tau_r_ * (l_m_ * i_s - psi_r) + (pole_pairs_ * omega_m) * rotate_90(psi_r);
  }

  /// Advances ψ_r by dt [s] (midpoint rule) with the mean current [A] and the speed [rad/s] of the interval.
  constexpr void step(SpaceVector<T> i_s_mean, T omega_m, T dt) noexcept {
    const SpaceVector<T> middle = psi_r_ + (T(0.5) * dt) * derivative(psi_r_, i_s_mean, omega_m);
    psi_r_ += dt * derivative(middle, i_s_mean, omega_m);
  }

  /// Stator flux that belongs to the present rotor flux and stator current. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> psi_s(SpaceVector<T> i_s) const noexcept {
    return k_r_ * psi_r_ + sigma_l_s_ * i_s;
  }

  /// Rotor flux that belongs to a stator flux and current: ψ_r = (ψ_s − σL_s i_s)/k_r. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> psi_r_from(SpaceVector<T> psi_s, SpaceVector<T> i_s) const noexcept {
    return (T(1) / k_r_) * (psi_s - sigma_l_s_ * i_s);
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_r() const noexcept { return psi_r_; }  ///< [Wb]
  constexpr void set(SpaceVector<T> psi_r) noexcept { psi_r_ = psi_r; }

  /// di_s/dt for the given stator voltage: (u_s − R_s i_s − k_r dψ_r/dt) / σL_s. [A/s]
  [[nodiscard]] constexpr SpaceVector<T> current_derivative(SpaceVector<T> u_minus_ri, SpaceVector<T> psi_r,
                                                            SpaceVector<T> i_s, T omega_m) const noexcept {
    return (T(1) / sigma_l_s_) * (u_minus_ri - k_r_ * derivative(psi_r, i_s, omega_m));
  }

 private:
  T inverse_tau_r_;
  T l_m_;
  T k_r_;
  T sigma_l_s_;
  T pole_pairs_;
  SpaceVector<T> psi_r_{};
};

}  // namespace sextant
