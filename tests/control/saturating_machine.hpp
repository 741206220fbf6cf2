#pragma once

#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// The reference machine with iron that saturates, fed by a current along its flux at standstill: the Γ
/// circuit, all leakage on the rotor's side,
///   i = ψ_s/L(ψ_s) + (ψ_s − ψ_R)/L_σ,   dψ_R/dt = R_R (i − ψ_s/L(ψ_s)),
///   1/L(ψ_s) = (1 + s ((ψ_s/1.1 Wb)^7 − 1))/L_s
/// Source: Z. Qu, M. Ranta, M. Hinkkanen, J. Luomi, "Loss-minimizing flux level control of induction motor
/// drives", IEEE Trans. Ind. Appl. 48 (2012) 952–961.
class SaturatingMachine {
 public:
  /// Without flux. saturation: s, the share of the magnetising current that the iron makes at 1.1 Wb.
  explicit SaturatingMachine(double saturation) : saturation_{saturation} {}

  /// A constant current [A] over dt [s].
  void advance(double current, double dt) {
    const double before = magnetising(psi_s_);
    const double from = psi_r_;
    psi_r_ += dt * r_r_ * (current - before);
    psi_s_ = stator(current);
    psi_r_ = from + dt * r_r_ * (current - 0.5 * (before + magnetising(psi_s_)));
    psi_s_ = stator(current);
  }

  [[nodiscard]] double psi_s() const { return psi_s_; }  ///< [Wb]

 private:
  [[nodiscard]] double magnetising(double psi_s) const {
    return psi_s / machine_.l_s() * (1 + saturation_ * (std::pow(psi_s / 1.1, 7) - 1));
  }
  /// ψ_s at this current and the rotor's flux, by Newton's method. [Wb]
  [[nodiscard]] double stator(double current) const {
    double psi = psi_s_;
    for (int n = 0; n < 8; ++n) {
      const double slope =
          (1 + saturation_ * (8 * std::pow(psi / 1.1, 7) - 1)) / machine_.l_s() + 1 / l_sigma_;
      psi -= (magnetising(psi) + (psi - psi_r_) / l_sigma_ - current) / slope;
    }
    return psi;
  }

  InductionMachineParameters<double> machine_{};
  double gamma_{machine_.l_s() / machine_.l_m};
  double l_sigma_{gamma_ * machine_.l_ls + gamma_ * gamma_ * machine_.l_lr};  ///< [H]
  double r_r_{gamma_ * gamma_ * machine_.r_r};                                ///< R_R [Ω]
  double saturation_;
  double psi_s_{};  ///< [Wb]
  double psi_r_{};  ///< ψ_R [Wb]
};

}  // namespace sextant
