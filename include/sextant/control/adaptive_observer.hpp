#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Full-order observer of stator current and rotor flux, x = (i_s, ψ_r):
///   dx̂/dt = A(ω_r) x̂ + B u_s + G (î_s − i_s)
/// The gains G make its poles k times those of the machine. The speed is measured, or adapted:
///   ω_r = P ε + K ∫ε dt,   ε = d σL_s/(k_r ψ_r²) (i_s − î_s) × ψ̂_r,   d = k (R_s + k_r² R_r)/σL_s
/// At constant flux ε follows an error dω of the speed with the pole d, and P and K go by it:
///   K = (1 + P)² d/2
/// places the poles of the adaptation at (1 + P) d/√2 with a damping of 1/√2. An electrical acceleration a
/// leaves dω = a/K; torque and flux are right while this is small beside 1/τ_r, that is a ≪ K/τ_r.
/// Without a speed sensor ω_r is not observable near zero stator frequency with load, where the voltage has
/// no trace of it.
/// Source: H. Kubota, K. Matsuse, T. Nakano, "DSP-based speed adaptive flux observer of induction motor",
/// IEEE Trans. Ind. Appl. 29 (1993) 344–348.
template <class T = double>
class AdaptiveObserver {
 public:
  AdaptiveObserver(const InductionMachineParameters<T>& machine, bool adapts_speed) noexcept
      : adapts_speed_{adapts_speed} {
    set_machine(machine);
  }

  /// Other parameters; the state stays.
  void set_machine(const InductionMachineParameters<T>& machine) noexcept {
    machine_ = machine;
    inverse_tau_r_ = T(1) / machine.tau_r();
    inverse_sigma_l_s_ = T(1) / machine.sigma_l_s();
    k_r_ = machine.k_r();
    damping_ = pole_factor * inverse_sigma_l_s_ * (machine.r_s + k_r_ * k_r_ * machine.r_r);
    pole_pairs_ = T(machine.pole_pairs);
  }

  /// Advances by dt [s]. volt_seconds: ∫u_s dt over it [V·s]; i_s: measured at its end [A]; omega_m: measured
  /// speed [rad/s], without meaning where the speed is adapted.
  void step(SpaceVector<T> volt_seconds, SpaceVector<T> i_s, T omega_m, T dt) noexcept {
    if (!adapts_speed_) omega_r_ = pole_pairs_ * omega_m;
    const SpaceVector<T> mean_voltage = (T(1) / dt) * volt_seconds;
    // Heun's rule; the measured current is known at the end only.
    const Slopes first = slopes(i_s_, psi_r_, mean_voltage);
    const Slopes second = slopes(i_s_ + dt * first.i_s, psi_r_ + dt * first.psi_r, mean_voltage);
    i_s_ += (T(0.5) * dt) * (first.i_s + second.i_s);
    psi_r_ += (T(0.5) * dt) * (first.psi_r + second.psi_r);
    const SpaceVector<T> error = i_s_ - i_s;
    correct(error, dt);
    if (adapts_speed_) adapt(error, dt);
  }

  /// Stator flux ψ_s = k_r ψ_r + σL_s i_s at the measured current. [Wb]
  [[nodiscard]] SpaceVector<T> psi_s(SpaceVector<T> i_s) const noexcept {
    return k_r_ * psi_r_ + (T(1) / inverse_sigma_l_s_) * i_s;
  }
  [[nodiscard]] T omega_m() const noexcept { return omega_r_ / pole_pairs_; }  ///< [rad/s]

  /// Sets rotor flux [Wb] and current [A]; the speed [rad/s] where it is adapted.
  void set(SpaceVector<T> psi_r, SpaceVector<T> i_s, T omega_m) noexcept {
    psi_r_ = psi_r;
    i_s_ = i_s;
    omega_r_ = integral_ = pole_pairs_ * omega_m;
  }

 private:
  struct Slopes {
    SpaceVector<T> i_s;    ///< [A/s]
    SpaceVector<T> psi_r;  ///< [V]
  };

  [[nodiscard]] Slopes slopes(SpaceVector<T> i_s, SpaceVector<T> psi_r, SpaceVector<T> u) const noexcept {
    const SpaceVector<T> psi_r_rate =
        inverse_tau_r_ * (machine_.l_m * i_s - psi_r) + omega_r_ * rotate_90(psi_r);
    return {inverse_sigma_l_s_ * (u - machine_.r_s * i_s - k_r_ * psi_r_rate), psi_r_rate};
  }

  /// G (î_s − i_s), for A = [a11 I, …; a21 I, a22 I + ω_r J] and c = σL_s L_r/L_m.
  void correct(SpaceVector<T> error, T dt) noexcept {
    const T a22 = -inverse_tau_r_;
    const T a11 = -inverse_sigma_l_s_ * (machine_.r_s + k_r_ * k_r_ * machine_.r_r);
    const T a21 = machine_.l_m * inverse_tau_r_;
    const T c = T(1) / (inverse_sigma_l_s_ * k_r_);
    const T more = pole_factor - T(1);
    const T g1 = more * (a11 + a22);
    const T g2 = more * omega_r_;
    const T g3 = (pole_factor * pole_factor - T(1)) * (c * a11 + a21) - c * g1;
    const T g4 = -c * g2;
    const SpaceVector<T> turned = rotate_90(error);
    i_s_ += dt * (g1 * error + g2 * turned);
    psi_r_ += dt * (g3 * error + g4 * turned);
  }

  void adapt(SpaceVector<T> error, T dt) noexcept {
    // While flux is built up the flux that the current will make is the scale.
    const T building = T(0.3) * machine_.l_m;
    const T square = dot(psi_r_, psi_r_) + building * building * dot(i_s_, i_s_);
    if (!(square > T(0))) return;
    // In a steady state an error dω of the speed makes an error of the current of some k_r dω ψ_r per σL_s
    // and damping: the cross product over this is an error of the speed.
    const T epsilon = damping_ / (inverse_sigma_l_s_ * k_r_) * cross(psi_r_, error) / square;
    const T proportion = std::min(largest_proportion, largest_turn / (damping_ * dt));
    const T rate = T(0.5) * (T(1) + proportion) * (T(1) + proportion) * damping_;
    integral_ += rate * dt * epsilon;
    omega_r_ = integral_ + proportion * epsilon;
  }

  static constexpr T pole_factor = T(1.5);        ///< k [-]
  static constexpr T largest_proportion = T(16);  ///< P: adaptation against the observer's pole [-]
  static constexpr T largest_turn = T(0.3);       ///< P d dt, for a loop that is closed once a step [-]

  InductionMachineParameters<T> machine_{};
  T inverse_tau_r_{};
  T inverse_sigma_l_s_{};
  T k_r_{};
  T damping_{};  ///< d [1/s]
  T pole_pairs_{};
  bool adapts_speed_;
  SpaceVector<T> i_s_{};
  SpaceVector<T> psi_r_{};
  T omega_r_{};   ///< electrical [rad/s]
  T integral_{};  ///< K_i ∫ε dt [rad/s]
};

}  // namespace sextant
