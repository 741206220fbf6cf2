#pragma once

#include <algorithm>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// The largest stator flux linkage that a DC link can make of a machine, whatever the speed does:
///   d|psi_r|/dt ≤ L_m/L_s |psi_s| R_r/σL_r − |psi_r| R_r/σL_r  and
///   d|psi_s|/dt ≤ |u_s| − R_s/σL_s (|psi_s| − k_r |psi_r|)  give  |psi_s| ≤ L_s/R_s |u_s|,
/// |u_s| ≤ 2/3 (u_dc + 2 V_t), with largest link voltage and smallest R_s so far; with saturation L_s is the
/// largest one, and iron loss makes d|psi_r|/dt smaller. An integration that goes beyond it has left the
/// machine's equations.
template <class T = double>
class FluxBound {
 public:
  /// The machine's largest stator inductance [H] and its stator resistance [Ω], above zero.
  void note_machine(T largest_inductance, T stator_resistance) noexcept SEXTANT_NONBLOCKING {
    flux_per_volt_ =
        std::max(flux_per_volt_, (T(1) + rounding) * T(2) / T(3) * largest_inductance / stator_resistance);
  }
  /// u_dc + 2 V_t. [V]
  void note_voltage(T u_dc) noexcept SEXTANT_NONBLOCKING { largest_u_dc_ = std::max(largest_u_dc_, u_dc); }

  [[nodiscard]] bool holds(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    const T limit = flux_per_volt_ * largest_u_dc_;
    return dot(psi_s, psi_s) <= limit * limit;
  }

 private:
  /// By which the bound may be passed without a reason.
  static constexpr T rounding = T(1e-3);

  T flux_per_volt_{};  ///< largest |psi_s| by u_dc, with the smallest R_s so far [s]
  T largest_u_dc_{};   ///< so far, with two thresholds [V]
};

}  // namespace sextant
