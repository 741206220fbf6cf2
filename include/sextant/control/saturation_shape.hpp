#pragma once

#include <algorithm>

namespace sextant {

/// How the rotor's flux may decay faster the more of it there is, because the iron saturates:
///   R_r/L_r = b (1 + s (g − 1)),   g = (ψ_s/ψ_ref)^7
/// with the magnetising current of a power law, ψ_s/L (1 + c ψ_s^7), whose exponent is that of the source's
/// machine. At the flux reference b is that of the parameters, whatever s is: L_m is that of the operating
/// point.
/// Source of the law: Z. Qu, M. Ranta, M. Hinkkanen, J. Luomi, "Loss-minimizing flux level control of
/// induction motor drives", IEEE Trans. Ind. Appl. 48 (2012) 952–961.
template <class T = double>
class SaturationShape {
 public:
  /// Standard deviation of s, which is not below zero: at the knee, where the inductance has fallen to half,
  /// s is 0.5. [-]
  static constexpr T deviation = T(0.3);

  /// flux_reference: ψ_ref [Wb].
  explicit constexpr SaturationShape(T flux_reference) noexcept : per_flux_{T(1) / flux_reference} {}

  /// g − 1, for a stator flux up to 1.25 ψ_ref, to which magnetising leads at most [Wb]. [-]
  [[nodiscard]] constexpr T excess(T psi_s) const noexcept {
    const T x = std::min(T(1.25), psi_s * per_flux_);
    const T cube = x * x * x;
    return cube * cube * x - T(1);
  }

 private:
  T per_flux_;  ///< 1/ψ_ref [1/Wb]
};

}  // namespace sextant
