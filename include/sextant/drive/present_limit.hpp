#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/drive/available_torque.hpp"

namespace sextant {

/// The largest torque by the present flux and current, for what the steady state of
/// `TorqueCapability` does not know: transients, and parameters of the machine that are wrong. Estimated flux
/// and measured current, of one instant, give two limits.
///
/// The stator current, flux first: the current along the flux is what it is, the rest is left for torque,
///   |τ_e| ≤ 3/2 p |ψ_s| √(I² − i_d²) = 3/2 p √((|ψ_s| I)² − (ψ_s · i_s)²)
/// It bounds the current that the torque reference causes; the current along the flux is the controller's.
/// Below a tenth of its reference the flux counts as that tenth: a machine without flux gets its first flux
/// by a torque reference (switching table).
///
/// Pull-out, while the flux is below its configured value: the angle δ between stator and rotor flux stays
/// below 42°, of which the breakdown torque has 45,
///   |τ_e| = 3/2 p/(σL_s) |ψ_s| |k_r ψ_r| sin δ,   k_r ψ_r = ψ_s − σL_s i_s
/// but for a twentieth of the breakdown torque at the flux, or at 32 % of its reference, for the same reason.
/// At larger angles the rotor flux decays and the torque with it, and a torque reference holds that state.
template <class T = double>
class PresentLimit {
 public:
  /// current_limit I: peak of the stator current vector [A]; flux_reference [Wb].
  constexpr PresentLimit(const InductionMachineParameters<T>& m, T flux_reference, T current_limit) noexcept
      : sigma_l_s_{m.sigma_l_s()},
        current_squared_{current_limit * current_limit},
        reference_squared_{flux_reference * flux_reference},
        gain_squared_{T(2.25) * T(m.pole_pairs) * T(m.pole_pairs)},
        angle_gain_{square_of_sin * gain_squared_ / (sigma_l_s_ * sigma_l_s_)},
        least_torque_{T(0.05) * T(0.75) * T(m.pole_pairs) * (T(1) / sigma_l_s_ - T(1) / m.l_s())} {}

  /// The limit by flux [Wb] and current [A] of one instant, at a share of the flux reference; none where it
  /// is at least `enough` [N·m].
  [[nodiscard]] LimitedTorque<T> step(SpaceVector<T> psi_s, SpaceVector<T> i_s, T flux_share,
                                      T enough) const noexcept {
    const T psi_squared = dot(psi_s, psi_s);
    const T along = dot(psi_s, i_s);
    const T flux_squared = std::max(psi_squared, T(0.01) * reference_squared_);
    LimitedTorque<T> square{gain_squared_ * (flux_squared * current_squared_ - along * along),
                            DeratingCause::current_limit};
    if (flux_share < T(1)) {
      const SpaceVector<T> psi_r = psi_s - sigma_l_s_ * i_s;  // k_r ψ_r
      const T by_angle = angle_gain_ * psi_squared * dot(psi_r, psi_r);
      const T least = least_torque_ * std::max(psi_squared, T(0.1) * reference_squared_);
      square.lower_to({std::max(by_angle, least * least), DeratingCause::voltage_limit});
    }
    if (square.torque >= enough * enough) return {};
    return {square.torque > T(0) ? std::sqrt(square.torque) : T(0), square.cause};
  }

 private:
  static constexpr T square_of_sin = T(0.448);  // sin² 42°

  T sigma_l_s_;          ///< [H]
  T current_squared_;    ///< I² [A²]
  T reference_squared_;  ///< of the flux [Wb²]
  T gain_squared_;       ///< (3/2 p)² [-]
  T angle_gain_;         ///< (3/2 p sin 42°/(σL_s))² [1/H²]
  T least_torque_;       ///< a twentieth of the breakdown torque by the square of the flux [N·m/Wb²]
};

}  // namespace sextant
