#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// The stator flux that the link can still turn with the rotor. With a = |ψ_s − σL_s i_s| = k_r ψ_r, torque
/// τ_e takes the current i_q = τ_e/(3/2 p a), and a generator's flux turns slower than its rotor by the slip
/// of it. At most the fundamental of six-step operation, U = 2/π u_dc, turns a flux of
///   ψ_max = U/ω,   ω = |ω_r|, of a generator less k_r² R_r |i_q|/a,   ω_r = p ω_m
/// and a larger one is left behind by the rotor: the torque moves against the rotation, whatever is asked.
/// So it happens where the link falls faster than the flux reference. The rotor flux follows with σ τ_r; what
/// the stator flux falls before it takes a current against it, for which the current limit I has to leave
/// room beside that of the torque. With s = σL_s the least flux within it is
///   ψ_min² = (a − s √(I² − i_q²))² + (s i_q)²
/// A motoring steady state of `TorqueCapability` has less than ψ_max.
template <class T = double>
class HeldFlux {
 public:
  /// current_limit I: peak of the stator current vector. [A]
  constexpr HeldFlux(const InductionMachineParameters<T>& m, T current_limit) noexcept
      : pole_pairs_{T(m.pole_pairs)},
        s_{m.sigma_l_s()},
        rotor_{m.k_r() * m.k_r() * m.r_r},
        current_limit_{current_limit} {}

  /// What a period begins with.
  struct Now {
    SpaceVector<T> psi_s{};  ///< [Wb]
    SpaceVector<T> i_s{};    ///< of the same instant [A]
    T omega_m{};             ///< mechanical speed [rad/s]
    T u_dc{};                ///< link voltage [V]
  };

  /// The larger of ψ_max and ψ_min beside a torque [N·m]; infinite where ψ_max is at least `enough` [Wb].
  /// [Wb]
  [[nodiscard]] T flux(const Now& now, T torque, T enough) const noexcept {
    const T omega_r = pole_pairs_ * std::abs(now.omega_m);
    const T u = now.u_dc * T(2 / std::numbers::pi);
    if (!(u < enough * omega_r)) return std::numeric_limits<T>::infinity();
    const SpaceVector<T> main = now.psi_s - s_ * now.i_s;
    const T a = std::sqrt(dot(main, main));
    const T i_q = std::min(current_limit_, std::abs(torque) / (T(1.5) * pole_pairs_ * a));
    const T slip = torque * now.omega_m < T(0) ? rotor_ * i_q / a : T(0);
    const T along = a - s_ * std::sqrt(current_limit_ * current_limit_ - i_q * i_q);
    const T across = s_ * i_q;
    const T omega = omega_r - slip;
    const T most = omega > T(0) ? u / omega : std::numeric_limits<T>::infinity();
    return std::max(most, std::sqrt(along * along + across * across));
  }

 private:
  T pole_pairs_;     ///< [-]
  T s_;              ///< σL_s [H]
  T rotor_;          ///< k_r² R_r [Ω]
  T current_limit_;  ///< I [A]
};

}  // namespace sextant
