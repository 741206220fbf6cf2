#pragma once

#include <cmath>

namespace example {

/// A permanent-magnet synchronous machine, in the frame of its magnets' flux:
///   psi_d = L_d i_d + psi_m,   psi_q = L_q i_q,   tau_e = 3/2 p (psi_m i_q + (L_d − L_q) i_d i_q)
/// The defaults are the 2.2 kW machine of motulator's examples (370 V, 4.3 A, 75 Hz, 14 N·m).
template <class T = double>
struct PmParameters {
  T r_s{T(3.6)};        ///< [Ω]
  T l_d{T(0.036)};      ///< [H]
  T l_q{T(0.051)};      ///< at least L_d [H]
  T psi_m{T(0.545)};    ///< of the magnets [Wb]
  int pole_pairs{3};    ///< p [-]
  T inertia{T(0.015)};  ///< of the shaft [kg·m²]

  [[nodiscard]] const char* validate() const noexcept {
    for (const T x : {r_s, l_d, l_q, psi_m, inertia}) {
      if (!(std::isfinite(x) && x > T(0))) return "a value of the machine is not above zero";
    }
    if (!(l_q >= l_d)) return "the machine's L_q must be at least its L_d";
    return pole_pairs > 0 ? nullptr : "the machine's pole pairs must be above zero";
  }
};

}  // namespace example
