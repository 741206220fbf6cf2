#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/control/current_model.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Voltage model corrected by the current model:
///   dψ_s/dt = u_s − R_s i_s − g (ψ_s − c ψ_cm)
///   dc/dt = γ w (1 + g/(jω_e)) (ψ_s − c ψ_cm)/ψ_cm − (1 − w)(c − 1)/τ_r
/// ψ_cm is the stator flux of the current model and c a complex factor that follows what its parameters are
/// wrong by. The correction removes drift and a wrong initial value within 1/g. Where w is 1 it has no effect
/// in steady state: the estimate is that of the voltage model, which needs neither R_r nor L_m. Where w is 0
/// the factor is 1 and the estimate that of the current model, which does not need R_s. w is the product of
///   ω_e²/(ω_e² + ω_1²)   and   ω_r⁴/(ω_r⁴ + ω_1⁴),  ω_r = p ω_m
/// ω_1 is that of `flux_crossover`; it and τ_r of these corners are those configured.
///
/// The correction lets only jω_e/(jω_e + g) of the difference ψ_v − c ψ_cm between the fluxes of both models
/// remain in ψ_s − c ψ_cm. Its inverse in the adaptation takes gain and phase back, so that c follows
/// ψ_v/ψ_cm with the time constant 1/γ. Without it c turns about its steady state at some γ ω_e/g and settles
/// at γ (ω_e/g)², within seconds at low frequency, and each torque step turns it anew. γ is the larger of
/// 1/τ_r and |ω_e|/2, at most g: each turn of the flux shows ψ_v, within the correction's bandwidth. The
/// return to 1 has 1/τ_r.
///
/// Sources: P. L. Jansen, R. D. Lorenz, "A physically insightful approach to the design and accuracy
/// assessment of flux observers for field oriented induction machine drives", IEEE Trans. Ind. Appl. 30
/// (1994) 101–110, for the two models joined by a correction; the factor c is this project's.
template <class T = double>
class HybridFluxModel {
 public:
  /// With what rates c follows ψ_v/ψ_cm and returns to 1.
  struct Rates {
    T follow{};        ///< γ w [1/s]
    T by_frequency{};  ///< γ w/ω_e, which is finite at zero stator frequency [-]
    T leak{};          ///< (1 − w)/τ_r [1/s]
  };

  /// crossover: ω_1. [rad/s]
  HybridFluxModel(const InductionMachineParameters<T>& machine, T crossover) noexcept
      : correction_{machine.r_s / machine.sigma_l_s()},
        inverse_tau_r_{T(1) / machine.tau_r()},
        crossover_{crossover},
        pole_pairs_{T(machine.pole_pairs)} {}

  /// Advances by dt [s]. flux_change: ∫(u_s − R_s i_s) dt [Wb]; current_model and i_s [A] at the end;
  /// omega_m: mechanical speed [rad/s].
  void step(SpaceVector<T> flux_change, const CurrentModel<T>& current_model, SpaceVector<T> i_s, T omega_m,
            T dt) noexcept {
    const SpaceVector<T> psi_cm = current_model.psi_s(i_s);
    const SpaceVector<T> psi_r = current_model.psi_r();
    const T k = dt / (smoothing + dt);
    turn_ += k * (cross(psi_r, current_model.derivative(psi_r, i_s, omega_m)) - turn_);
    norm_ += k * (dot(psi_r, psi_r) - norm_);
    const T omega_e = norm_ > T(0) ? std::clamp(turn_ / norm_, -highest, highest) : T(0);
    rates_ = rates(omega_e, pole_pairs_ * omega_m);
    psi_s_ += flux_change;
    const SpaceVector<T> error = psi_s_ - reference(psi_cm);
    psi_s_ -= (correction_ * dt / (T(1) + correction_ * dt)) * error;
    const T square = dot(psi_cm, psi_cm);
    if (!(square > T(0))) return;
    const SpaceVector<T> difference =
        (dt / square) * (rates_.follow * error - (correction_ * rates_.by_frequency) * rotate_90(error));
    const T leak = rates_.leak * dt;
    factor_.alpha += dot(psi_cm, difference) - leak * (factor_.alpha - T(1));
    factor_.beta += cross(psi_cm, difference) - leak * factor_.beta;
    bound();
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_s() const noexcept { return psi_s_; }  ///< [Wb]
  /// c − 1. [-]
  [[nodiscard]] constexpr SpaceVector<T> excess() const noexcept {
    return {factor_.alpha - T(1), factor_.beta};
  }
  [[nodiscard]] constexpr const Rates& rates() const noexcept { return rates_; }

  /// What the factor has of errors that the current model and R_s have no more. [-]
  constexpr void correct(SpaceVector<T> excess) noexcept { factor_ -= excess; }

  /// Sets the flux [Wb]; the factor is 1 again, and the stator frequency begins anew.
  constexpr void set(SpaceVector<T> psi_s) noexcept {
    psi_s_ = psi_s;
    factor_ = {T(1), T(0)};
    turn_ = norm_ = T(0);
    rates_ = {};
  }

 private:
  static constexpr T smoothing = T(0.003);  ///< of the stator frequency [s]
  static constexpr T farthest = T(0.6);     ///< largest |c − 1| [-]
  static constexpr T highest = T(1e5);      ///< largest stator frequency [rad/s]

  /// From the smoothed stator frequency and the rotor's.
  [[nodiscard]] Rates rates(T omega_e, T omega_r) const noexcept {
    const T r = omega_r * omega_r;
    const T w_1 = crossover_ * crossover_;
    const T by_frequency = omega_e * r * r / ((omega_e * omega_e + w_1) * (r * r + w_1 * w_1));
    const T share = omega_e * by_frequency;
    const T gamma = std::min(correction_, std::max(inverse_tau_r_, T(0.5) * std::abs(omega_e)));
    return {gamma * share, gamma * by_frequency, inverse_tau_r_ * (T(1) - share)};
  }

  [[nodiscard]] constexpr SpaceVector<T> reference(SpaceVector<T> psi_cm) const noexcept {
    return factor_.alpha * psi_cm + factor_.beta * rotate_90(psi_cm);
  }

  void bound() noexcept {
    const T re = factor_.alpha - T(1);
    const T square = re * re + factor_.beta * factor_.beta;
    if (!(square > farthest * farthest)) return;
    const T shrink = farthest / std::sqrt(square);
    factor_ = {T(1) + shrink * re, shrink * factor_.beta};
  }

  T correction_;     ///< g [1/s]
  T inverse_tau_r_;  ///< [1/s]
  T crossover_;      ///< ω_1 [rad/s]
  T pole_pairs_;     ///< p [-]
  T turn_{};         ///< smoothed ψ_r × dψ_r/dt [V·Wb]
  T norm_{};         ///< smoothed |ψ_r|² [Wb²]
  SpaceVector<T> psi_s_{};
  SpaceVector<T> factor_{T(1), T(0)};  ///< c [-]
  Rates rates_{};
};

}  // namespace sextant
