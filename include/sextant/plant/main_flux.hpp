#pragma once

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/magnetising_points.hpp"
#include "sextant/plant/magnetising_table.hpp"

namespace sextant {

/// What saturation of the main flux adds to the stator current of a linear machine, g(|psi_s|) psi_s: by the
/// law of `SaturationCurve`, or by a table, g = i(ψ)/ψ − 1/L_s.
template <class T = double>
class MainFlux {
 public:
  /// No saturation.
  constexpr MainFlux() noexcept = default;

  /// l_s: stator inductance of the machine's parameters [H]. Points take the place of the law.
  constexpr MainFlux(const SaturationParameters<T>& law, const MagnetisingPoints<T>& points, T l_s) noexcept
      : l_s_{l_s} {
    if (points.acts())
      table_ = MagnetisingTable<T>{points};
    else
      curve_ = SaturationCurve<T>{law, l_s};
  }

  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING {
    return curve_.acts() || table_.acts();
  }
  [[nodiscard]] constexpr bool is_table() const noexcept SEXTANT_NONBLOCKING { return table_.acts(); }
  [[nodiscard]] constexpr const SaturationCurve<T>& curve() const noexcept SEXTANT_NONBLOCKING {
    return curve_;
  }

  /// g at a stator flux. [1/H]
  [[nodiscard]] T added(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    return table_.acts() ? table_.by_flux(magnitude(psi_s)) - T(1) / l_s_ : curve_.added(psi_s);
  }
  /// By how much the added current rises along the flux more than across it; below zero in the foot of a
  /// table. [1/H]
  [[nodiscard]] T added_along(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    if (!table_.acts()) return curve_.added_along(psi_s);
    const T psi = magnitude(psi_s);
    return table_.slope(psi) - table_.by_flux(psi);
  }
  /// ∫ g psi dpsi from zero flux. [A·Wb]
  [[nodiscard]] T added_energy(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    if (!table_.acts()) return curve_.added_energy(psi_s);
    return table_.energy(magnitude(psi_s)) - dot(psi_s, psi_s) / (T(2) * l_s_);
  }
  /// The largest stator inductance by that of the machine's parameters, not below it. [-]
  [[nodiscard]] constexpr T largest_inductance_ratio() const noexcept SEXTANT_NONBLOCKING {
    return table_.acts() ? table_.largest_inductance() / l_s_ : curve_.largest_inductance_ratio();
  }

 private:
  SaturationCurve<T> curve_{};
  MagnetisingTable<T> table_{};
  T l_s_{1};  ///< [H]
};

}  // namespace sextant
