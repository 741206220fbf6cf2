#pragma once

#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Current model of the rotor flux in the stationary frame,
///   dψ_r/dt = −ψ_r/τ_r + j p ω_m ψ_r + (L_m/τ_r) i_s,   ψ_s = k_r ψ_r + σL_s i_s.
/// It needs the speed but no voltage: with gates off diodes and EMF, not the gate pattern, decide the
/// voltage. An error of the flux decays with τ_r, over steps of any length, because a step is the exact
/// solution. Source: P. Vas, Sensorless Vector and Direct Torque Control, Oxford 1998.
template <class T = double>
class CurrentModel {
 public:
  constexpr explicit CurrentModel(const InductionMachineParameters<T>& machine) noexcept {
    set_machine(machine);
  }

  /// Other parameters; the flux stays.
  constexpr void set_machine(const InductionMachineParameters<T>& machine) noexcept {
    inverse_tau_r_ = T(1) / machine.tau_r();
    l_m_ = machine.l_m;
    k_r_ = machine.k_r();
    sigma_l_s_ = machine.sigma_l_s();
    pole_pairs_ = T(machine.pole_pairs);
  }

  /// dψ_r/dt. [V]
  [[nodiscard]] constexpr SpaceVector<T> derivative(SpaceVector<T> psi_r, SpaceVector<T> i_s,
                                                    T omega_m) const noexcept {
    return inverse_tau_r_ * (l_m_ * i_s - psi_r) + (pole_pairs_ * omega_m) * rotate_90(psi_r);
  }

  /// Advances ψ_r by dt [s] with the mean current [A] and speed [rad/s] of the interval, exactly for constant
  /// ones: ψ_r += dt φ(λ dt) dψ_r/dt with φ(z) = (e^z − 1)/z and λ = −1/τ_r + j p ω_m.
  void step(SpaceVector<T> i_s_mean, T omega_m, T dt) noexcept {
    const SpaceVector<T> z{-inverse_tau_r_ * dt, pole_pairs_ * omega_m * dt};
    const SpaceVector<T> rate = derivative(psi_r_, i_s_mean, omega_m);
    psi_r_ += dt * product(phi(z), rate);
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
  /// (e^z − 1)/z. Its series to z⁴ errs by less than 1e-9 up to |z| = 0.05, where the closed form, without a
  /// difference of nearly equal numbers, takes over.
  [[nodiscard]] static SpaceVector<T> phi(SpaceVector<T> z) noexcept {
    const T z_squared = dot(z, z);
    if (z_squared < T(0.0025)) {
      SpaceVector<T> sum{T(1) + z.alpha / T(5), z.beta / T(5)};
      for (const T n : {T(4), T(3), T(2)}) {
        sum = (T(1) / n) * product(z, sum);
        sum.alpha += T(1);
      }
      return sum;
    }
    const T half = std::sin(T(0.5) * z.beta);
    const T growth = std::expm1(z.alpha);
    const SpaceVector<T> gain{growth * std::cos(z.beta) - T(2) * half * half,
                              (growth + T(1)) * std::sin(z.beta)};  // e^z − 1
    const T scale = T(1) / z_squared;
    return {scale * dot(gain, z), scale * cross(z, gain)};
  }

  T inverse_tau_r_{};
  T l_m_{};
  T k_r_{};
  T sigma_l_s_{};
  T pole_pairs_{};
  SpaceVector<T> psi_r_{};
};

}  // namespace sextant
