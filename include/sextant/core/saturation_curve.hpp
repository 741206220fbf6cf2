#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// What saturation of the main flux adds to the stator current of a linear induction machine.
///
/// In the Γ circuit, all leakage on the rotor's side, with gamma = L_s/L_m and psi_R = gamma psi_r,
///   i_s = psi_s/L_s + (psi_s − psi_R)/L_sigma,   L_sigma = gamma L_ls + gamma² L_lr
/// is the linear machine, with the same i_s and the same rotor equation as the T circuit. With an L_s that
/// depends on |psi_s| alone the second term and the rotor's current stay what they are, and the stator
/// current becomes that of the linear machine plus
///   g(|psi_s|) psi_s,   g = 1/L_s(|psi_s|) − 1/L_s = (y − y_N)/L_su,   y = (|psi_s|/psi_k)^S
/// with y_N at the flux where the machine's parameters hold and L_su = L_s (1 + y_N). The added current is
/// along psi_s: the torque at given fluxes is that of the linear machine. It is the gradient of an energy
/// that depends on |psi_s| alone, so that the field stays without loss.
///
/// Source of circuit and law: Z. Qu, M. Ranta, M. Hinkkanen, J. Luomi, "Loss-minimizing flux level control of
/// induction motor drives", IEEE Trans. Ind. Appl. 48 (2012) 952–961. S is a whole number, so that the curve
/// needs products only and is the same to the bit on each computer.
template <class T = double>
class SaturationCurve {
 public:
  /// No saturation.
  constexpr SaturationCurve() noexcept = default;

  /// l_s: stator inductance of the machine's parameters. [H]
  constexpr SaturationCurve(const SaturationParameters<T>& parameters, T l_s) noexcept {
    if (!parameters.acts()) return;
    acts_ = true;
    pairs_ = parameters.exponent / 2;
    is_odd_ = parameters.exponent % 2 != 0;
    exponent_ = T(parameters.exponent);
    inverse_knee_squared_ = T(1) / (parameters.knee * parameters.knee);
    y_machine_ = y({parameters.machine_flux, T(0)});
    inverse_l_su_ = T(1) / (l_s * (T(1) + y_machine_));
  }

  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING { return acts_; }

  /// g at a stator flux: the added current by the flux. [1/H]
  [[nodiscard]] T added(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    return (y(psi_s) - y_machine_) * inverse_l_su_;
  }
  /// By how much the added current rises along the flux more than across it, |psi_s| dg/d|psi_s|; not below
  /// zero. [1/H]
  [[nodiscard]] T added_along(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    return exponent_ * y(psi_s) * inverse_l_su_;
  }
  /// The linear machine that has the same currents at a stator flux: the chord of the curve. With
  /// L_s(|psi_s|) by the L_s of the machine, r, the Γ circuit's gamma, L_sigma and rotor resistance stay
  /// where
  ///   L_m r,   L_ls r,   L_lr + (1 − r) L_ls/gamma
  /// take the place of L_m, L_ls and L_lr, of which the last may fall below zero at small fluxes.
  [[nodiscard]] InductionMachineParameters<T> machine_at(
      InductionMachineParameters<T> machine, SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    if (!acts_) return machine;
    const T r = (T(1) + y_machine_) / (T(1) + y(psi_s));
    machine.l_lr += (T(1) - r) * machine.l_ls * machine.l_m / machine.l_s();
    machine.l_ls *= r;
    machine.l_m *= r;
    return machine;
  }
  /// Share by which L_s falls for a small share that the flux rises, −d ln L_s/d ln|psi_s| = S y/(1 + y);
  /// zero without saturation. [-]
  [[nodiscard]] T steepness(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    const T share = y(psi_s);
    return exponent_ * share / (T(1) + share);
  }
  /// ∫ g psi dpsi from zero flux. [A·Wb]
  [[nodiscard]] T added_energy(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    return dot(psi_s, psi_s) * inverse_l_su_ * (y(psi_s) / (exponent_ + T(2)) - y_machine_ / T(2));
  }
  /// A bound from above of the flux x psi_k at which y psi_s/L_su is the given current [A], close enough for
  /// Newton's method: x^(S+1) = r = current L_su/psi_k, and x ≤ max(1, r^(1/n)) for each n up to S + 1; n is
  /// a power of 2, so that square roots will do. [Wb]
  [[nodiscard]] T largest_flux(T current) const noexcept SEXTANT_NONBLOCKING {
    const T knee = T(1) / std::sqrt(inverse_knee_squared_);
    T x = current / (inverse_l_su_ * knee);
    for (int n = 2; T(n) <= exponent_ + T(1); n *= 2) x = std::sqrt(x);
    return knee * std::max(T(1), x);
  }
  /// L_su by the L_s of the machine's parameters. [-]
  [[nodiscard]] constexpr T largest_inductance_ratio() const noexcept SEXTANT_NONBLOCKING {
    return T(1) + y_machine_;
  }

 private:
  /// (|psi_s|/psi_k)^S. [-]
  [[nodiscard]] T y(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    const T square = dot(psi_s, psi_s) * inverse_knee_squared_;
    T power = is_odd_ ? std::sqrt(square) : T(1);
    for (int n = 0; n < pairs_; ++n) power *= square;
    return power;
  }

  bool acts_{false};
  bool is_odd_{false};        ///< of the exponent
  int pairs_{};               ///< half of the exponent, rounded down [-]
  T exponent_{};              ///< S [-]
  T inverse_knee_squared_{};  ///< 1/psi_k² [1/Wb²]
  T y_machine_{};             ///< y_N [-]
  T inverse_l_su_{};          ///< 1/L_su [1/H]
};

}  // namespace sextant
