#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Voltage model whose integrator is a low-pass filter, so that a wrong initial value and drift decay, with
/// its error of gain and phase in steady state taken back:
///   dx/dt = e − a x,   e = u_s − R_s i_s,   a = |ω_e|/k,   ψ_s = (1 − j sign(ω_e)/k) x
/// In steady state x = e/(jω_e + a), so that ψ_s = e/(jω_e), which is the integral. It needs neither speed
/// nor rotor parameters; at ω_e = 0 it is blind, and `least_frequency` bounds a from below. Source: M.-H.
/// Shin, D.-S. Hyun, S.-B. Cho, S.-Y. Choe, "An improved stator flux estimation for speed sensorless stator
/// flux orientation control of induction motors", IEEE Trans. Power Electron. 15 (2000) 312–318.
template <class T = double>
class CompensatedVoltageModel {
 public:
  /// `least_frequency`: ω_e below which the pole of the filter stays where it is. [rad/s]
  constexpr explicit CompensatedVoltageModel(T least_frequency) noexcept
      : least_frequency_{least_frequency} {}

  /// Advances by dt [s]; `volt_seconds`: ∫(u_s − R_s i_s) dt over it [V·s].
  void step(SpaceVector<T> volt_seconds, T dt) noexcept {
    const T norm = dot(psi_s_, psi_s_);
    const T seen = norm > T(0) ? cross(psi_s_, volt_seconds) / norm : T(0);
    omega_e_ += (seen - omega_e_ * dt) / (smoothing + dt);
    const T a = std::max(std::abs(omega_e_), least_frequency_) / pole_ratio;
    x_ += (T(1) / (T(1) + a * dt)) * (volt_seconds - (a * dt) * x_);
    psi_s_ = x_ - compensation() * rotate_90(x_);
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_s() const noexcept { return psi_s_; }  ///< [Wb]

  /// Sets the flux [Wb] and the frequency at which it rotates [rad/s].
  constexpr void set(SpaceVector<T> psi_s, T omega_e) noexcept {
    omega_e_ = omega_e;
    psi_s_ = psi_s;
    const T q = compensation();
    x_ = (T(1) / (T(1) + q * q)) * (psi_s + q * rotate_90(psi_s));
  }

 private:
  /// sign(ω_e)/k; below `least_frequency` the filter's own phase, ω_e over its pole by k². [-]
  [[nodiscard]] constexpr T compensation() const noexcept {
    return std::clamp(omega_e_ / least_frequency_, T(-1), T(1)) / pole_ratio;
  }

  static constexpr T pole_ratio = T(5);     ///< k: the pole lies at ω_e/k [-]
  static constexpr T smoothing = T(0.002);  ///< time constant of the measured frequency [s]

  T least_frequency_;
  T omega_e_{};             ///< stator frequency [rad/s]
  SpaceVector<T> x_{};      ///< state of the filter [Wb]
  SpaceVector<T> psi_s_{};  ///< [Wb]
};

}  // namespace sextant
