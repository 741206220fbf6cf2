#pragma once

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/iron_loss_parameters.hpp"

namespace sextant {

/// Iron loss of an induction machine: a branch beside the magnetising inductance of the inverse-Γ circuit,
/// all leakage on the stator's side, with psi_R = k_r psi_r, L_M = k_r L_m, R_R = k_r² R_r:
///   psi_s = σL_s i_s + psi_R,   i_s = psi_R/L_M + i_R + i_fe,   R_R i_R = dpsi_R/dt − j p omega_m psi_R
///   i_fe = dpsi_R/dt / R_e + omega_h/R_h |psi_R| (dpsi_R/dt)/|dpsi_R/dt|
/// The second term is rate-independent: of a flux that turns with omega, |dpsi_R/dt| = |omega psi_R|, both
/// terms together are the resistance `IronLossParameters` has, with the loss
///   P_fe = 3/2 i_fe · dpsi_R/dt = 3/2 |psi_R|² (omega²/R_e + omega_h |omega|/R_h).
/// As i_fe is along dpsi_R/dt, the loss is never negative.
///
/// With f, the dpsi_r/dt that a machine without iron loss has at the same fluxes, e = R_R/R_e and
/// b = R_R omega_h/R_h, this is
///   dpsi_r/dt = (1 − s) f,   k_r i_fe = s f/R_r,   s = (e |f| + b |psi_r|)/((1 + e) |f|)
/// and where |f| ≤ b |psi_r| hysteresis holds the flux, s = 1. No state is added, none gets stiff, and the
/// stator current is the function of the flux linkages that it is without iron loss, with saturation as
/// without. The torque is that of the rotor's current, 3/2 p psi_R × i_R.
///
/// What this neglects: the branch sees the flux behind both leakages, so that iron of leakage paths and the
/// voltage of the switching, which the leakage takes, lose nothing.
///
/// Sources: E. Levi, "Impact of iron loss on behavior of vector controlled induction machines", IEEE Trans.
/// Ind. Appl. 31 (1995) 1287–1296, for the branch; M. Ranta, M. Hinkkanen, E. Dlala, A.-K. Repo, J. Luomi,
/// "Inclusion of hysteresis and eddy current losses in dynamic induction machine models", IEEE IEMDC 2009,
/// 1387–1392, for hysteresis by space vectors; the Modelica Standard Library's
/// Electrical.Machines.Losses.InductionMachines.Core has the same R_fe(omega).
template <class T = double>
class IronLoss {
 public:
  /// No iron loss.
  constexpr IronLoss() noexcept = default;

  constexpr IronLoss(const IronLossParameters<T>& parameters,
                     const InductionMachineParameters<T>& machine) noexcept {
    if (!parameters.acts()) return;
    acts_ = true;
    const T r_rotor = machine.k_r() * machine.k_r() * machine.r_r;
    if (parameters.eddy_resistance > T(0)) eddy_ = r_rotor / parameters.eddy_resistance;
    hysteresis_ = r_rotor * parameters.hysteresis();
  }

  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING { return acts_; }

  /// Multiplies R_R by a ratio [-]; the iron's own resistances stay.
  constexpr void scale_rotor_resistance(T ratio) noexcept SEXTANT_NONBLOCKING {
    eddy_ *= ratio;
    hysteresis_ *= ratio;
  }

  /// s, by which the iron loss shortens f, the slope of the rotor flux linkage without it [V]. [-]
  [[nodiscard]] T share(SpaceVector<T> f, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const T holding = hysteresis_ * magnitude(psi_r);
    const T driving = magnitude(f);
    if (!(driving > holding)) return T(1);
    return (eddy_ + holding / driving) / (T(1) + eddy_);
  }

  /// dpsi_r/dt = (1 − s) f. [V]
  [[nodiscard]] SpaceVector<T> shortened(SpaceVector<T> f,
                                         SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return (T(1) - share(f, psi_r)) * f;
  }

  /// Slopes of dpsi_r/dt: by f along and across f, and, along f, by the magnitude of psi_r.
  struct Slopes {
    T along{};    ///< [-]
    T across{};   ///< [-]
    T by_flux{};  ///< [1/s]
  };
  [[nodiscard]] Slopes slopes(SpaceVector<T> f, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const T moving = T(1) - share(f, psi_r);
    if (!(moving > T(0))) return {};
    return {T(1) / (T(1) + eddy_), moving, -hysteresis_ / (T(1) + eddy_)};
  }

  /// By how much hysteresis makes the rotor flux linkage settle faster, at most: b. [1/s]
  [[nodiscard]] constexpr T damping() const noexcept SEXTANT_NONBLOCKING { return hysteresis_; }

 private:
  bool acts_{false};
  T eddy_{};        ///< e = R_R/R_e [-]
  T hysteresis_{};  ///< b = R_R omega_h/R_h [1/s]
};

}  // namespace sextant
