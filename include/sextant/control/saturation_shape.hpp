#pragma once

#include <algorithm>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/saturation_parameters.hpp"

namespace sextant {

/// How the rotor's flux decays faster the more of it there is, because the iron saturates. In the Γ circuit,
/// whose magnetising current is a power law of the stator flux, ψ_s/L (1 + c ψ_s^n), it exceeds that of the
/// machine's parameters by
///   s G/L_s,   G = (g − 1) ψ_s,   g = (ψ_s/ψ_ref)^n
/// At the flux reference it is that of the parameters, whatever s is: L_m is that of the operating point. The
/// flux behind the leakage of the parameters, φ = ψ_s − σL_s i, is then below k_r ψ_r by σ s G, and
///   dφ/dt = k_r² R_r i − (R_r/L_r) (φ + s G) − σ s dG/dt
/// Source of circuit and law: Z. Qu, M. Ranta, M. Hinkkanen, J. Luomi, "Loss-minimizing flux level control of
/// induction motor drives", IEEE Trans. Ind. Appl. 48 (2012) 952–961.
template <class T = double>
class SaturationShape {
 public:
  /// To which magnetising leads the stator flux at most, as a multiple of ψ_ref. [-]
  static constexpr T most_flux = T(1.25);

  /// What is known before of s, which is not below zero: at the knee, where the inductance has fallen to
  /// half, it is 0.5; and of n, which is 7 for the source's machine.
  struct Knowledge {
    T mean{};             ///< [-]
    T deviation{T(0.3)};  ///< standard [-]
    int exponent{7};      ///< n [-]
  };

  /// By a curve that is known: s = y/(1 + y), y = (ψ_ref/ψ_k)^n, but for what the knee may be off by, 2 % of
  /// which are 0.04 of s.
  [[nodiscard]] static Knowledge of(const SaturationParameters<T>& curve, T flux_reference) noexcept {
    if (!curve.acts()) return {};
    const T y = curve.excess(flux_reference);
    return {.mean = y / (T(1) + y), .deviation = T(0.05), .exponent = curve.exponent};
  }

  /// From the parameters as configured. flux_reference: ψ_ref [Wb].
  constexpr SaturationShape(const InductionMachineParameters<T>& machine, T flux_reference,
                            const Knowledge& known) noexcept
      : known_{known},
        per_flux_{T(1) / flux_reference},
        sigma_l_s_{machine.sigma_l_s()},
        sigma_{machine.sigma_l_s() / machine.l_s()},
        tau_r_{machine.tau_r()} {}

  [[nodiscard]] constexpr const Knowledge& known() const noexcept { return known_; }

  /// G at φ = `flux` [Wb] and a current along it [A]. [Wb]
  [[nodiscard]] constexpr T excess(T flux, T current) const noexcept {
    return excess(flux + sigma_l_s_ * current);
  }
  /// A course begins at φ = `flux` [Wb] and a current along it [A].
  constexpr void begin(T flux, T current) noexcept {
    first_ = excess_ = excess(flux + sigma_l_s_ * current);
    integral_ = integral_by_ = by_ = T(0);
  }
  /// dt [s] at φ = `flux` [Wb] and a current along it [A].
  constexpr void add(T flux, T current, T dt) noexcept { add(flux, current, dt, T(0), T(0)); }
  /// The same where φ hangs on an unknown x: `flux` is that for x = `at`, and changes with x by `by`.
  constexpr void add(T flux, T current, T dt, T at, T by) noexcept {
    const T psi_s = flux + sigma_l_s_ * current;
    by_ = slope(psi_s) * by;
    excess_ = excess(psi_s) - by_ * at;
    integral_ += dt * excess_;
    integral_by_ += dt * by_;
  }
  /// By what φ falls short for s = 1 and x = 0, as a multiple of R_r/L_r: ∫G dt + σ τ_r (G − G_0). [Wb·s]
  [[nodiscard]] constexpr T course() const noexcept {
    return integral_ + sigma_ * tau_r_ * (excess_ - first_);
  }
  /// Its change with x, to first order from where each part was added. [Wb·s by the unit of x]
  [[nodiscard]] constexpr T course_by() const noexcept { return integral_by_ + sigma_ * tau_r_ * by_; }

 private:
  /// g at a stator flux, from no flux up to the most. [-]
  [[nodiscard]] constexpr T power(T psi_s) const noexcept {
    const T x = std::clamp(psi_s * per_flux_, T(0), most_flux);
    T power = T(1);
    for (int n = 0; n < known_.exponent; ++n) power *= x;
    return power;
  }
  /// G. [Wb]
  [[nodiscard]] constexpr T excess(T psi_s) const noexcept { return psi_s * (power(psi_s) - T(1)); }
  /// dG/dψ_s. [-]
  [[nodiscard]] constexpr T slope(T psi_s) const noexcept {
    const bool follows = psi_s * per_flux_ < most_flux;
    return (follows ? T(known_.exponent + 1) : T(1)) * power(psi_s) - T(1);
  }

  Knowledge known_;
  T per_flux_;       ///< 1/ψ_ref [1/Wb]
  T sigma_l_s_;      ///< σL_s [H]
  T sigma_;          ///< σ [-]
  T tau_r_;          ///< L_r/R_r [s]
  T first_{};        ///< G_0 [Wb]
  T excess_{};       ///< G for x = 0 [Wb]
  T integral_{};     ///< ∫G dt for x = 0 [Wb·s]
  T by_{};           ///< dG/dx
  T integral_by_{};  ///< ∫dG/dx dt
};

}  // namespace sextant
