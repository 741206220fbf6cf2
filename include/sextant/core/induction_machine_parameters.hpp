#pragma once

#include <cmath>

namespace sextant {

/// Squirrel-cage induction machine, T-equivalent circuit referred to the stator, linear magnetics.
/// Defaults are the paper's Table 2, reactances at 50 Hz.
template <class T = double>
struct InductionMachineParameters {
  T r_s{T(0.435)};             ///< stator resistance [Ω]
  T r_r{T(0.816)};             ///< rotor resistance [Ω]
  T l_ls{T(0.0024000565427)};  ///< stator leakage inductance, 0.754 Ω at 50 Hz [H]
  T l_lr{T(0.0024000565427)};  ///< rotor leakage inductance, 0.754 Ω at 50 Hz [H]
  T l_m{T(0.083174)};          ///< magnetising inductance, 26.13 Ω at 50 Hz [H]
  int pole_pairs{2};           ///< p, half the number of poles [-]
  T inertia{T(0.089)};         ///< J of rotor and shaft [kg·m²]

  [[nodiscard]] constexpr T l_s() const noexcept { return l_ls + l_m; }  ///< stator inductance [H]
  [[nodiscard]] constexpr T l_r() const noexcept { return l_lr + l_m; }  ///< rotor inductance [H]
  /// Rotor coupling factor k_r = L_m / L_r. [-]
  [[nodiscard]] constexpr T k_r() const noexcept { return l_m / l_r(); }
  /// Transient stator inductance σL_s = L_s − L_m²/L_r. [H]
  [[nodiscard]] constexpr T sigma_l_s() const noexcept { return l_s() - l_m * k_r(); }
  /// Rotor time constant L_r / R_r. [s]
  [[nodiscard]] constexpr T tau_r() const noexcept { return l_r() / r_r; }

  /// nullptr when the values make a machine, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto positive = [](T x) { return std::isfinite(x) && x > T(0); };
    if (!positive(r_s)) return "the stator resistance must be finite and above zero";
    if (!positive(r_r)) return "the rotor resistance must be finite and above zero";
    if (!positive(l_ls) || !positive(l_lr)) return "the leakage inductances must be finite and above zero";
    if (!positive(l_m)) return "the magnetising inductance must be finite and above zero";
    if (pole_pairs < 1) return "the machine needs at least one pole pair";
    if (!positive(inertia)) return "the inertia must be finite and above zero";
    return nullptr;
  }
};

}  // namespace sextant
