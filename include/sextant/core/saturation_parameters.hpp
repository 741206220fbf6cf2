#pragma once

#include <cmath>

#include "sextant/core/description.hpp"

namespace sextant {

/// Saturation of the main flux; none by default. The stator inductance of the Γ circuit depends on the stator
/// flux linkage as
///   L_s(psi) = L_su / (1 + (psi/psi_k)^S)
/// and all other elements of that circuit keep their values (`SaturationCurve`, which names the source). The
/// measured 2.2 kW machine of motulator's examples has psi_k = 1.19 Wb and S = 7 at a rated flux of 1.04 Wb,
/// where L_su is 1.4 L_s.
template <class T = double>
struct SaturationParameters {
  T knee{};         ///< psi_k, where L_s is half of what it is without saturation; 0: no saturation [Wb]
  int exponent{7};  ///< S [-]
  /// psi_N, where L_s is that of the machine's parameters, as a no-load test at rated voltage gives it; 0:
  /// they hold for small fluxes, L_su = L_s. [Wb]
  T machine_flux{};

  static constexpr int smallest_exponent = 2;
  static constexpr int largest_exponent = 20;
  /// L_su by the L_s of the machine's parameters, at most. [-]
  static constexpr T largest_ratio = T(10);

  friend constexpr bool operator==(const SaturationParameters&,
                                   const SaturationParameters&) noexcept = default;

  [[nodiscard]] constexpr bool acts() const noexcept { return knee > T(0); }

  /// (psi/psi_k)^S, by which L_su is larger than L_s at that flux [Wb]. [-]
  [[nodiscard]] T excess(T psi) const noexcept { return acts() ? std::pow(psi / knee, T(exponent)) : T(0); }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(knee) && knee >= T(0)))
      return "the knee of the saturation must be finite and not below zero";
    if (exponent < smallest_exponent || exponent > largest_exponent)
      return "the exponent of the saturation must be from 2 to 20";
    if (!(std::isfinite(machine_flux) && machine_flux >= T(0)))
      return "the flux at which the machine's inductances hold must be finite and not below zero";
    if (!(T(1) + excess(machine_flux) <= largest_ratio))
      return "the flux at which the machine's inductances hold is too far above the knee of the saturation: "
             "without saturation they would be more than ten times as large";
    return nullptr;
  }
};

template <class T>
void describe(Description& d, SaturationParameters<T>& p) {
  auto& [knee, exponent, machine_flux] = p;
  d.number("knee_wb", knee,
           {"Wb", 0, 1e3,
            "stator flux linkage at which the machine's stator inductance L_ls + L_m has fallen to half of "
            "what it is at small fluxes: L_su/(1 + (psi_s/knee_wb)^exponent); all other elements of the Γ "
            "circuit are constant; 0: it does not saturate"});
  d.integer("exponent", exponent, "", SaturationParameters<T>::smallest_exponent,
            SaturationParameters<T>::largest_exponent,
            "of the same, how sharp the knee is; counts where knee_wb is not 0");
  d.number(
      "machine_flux_wb", machine_flux,
      {"Wb", 0, 1e3,
       "stator flux linkage at which the stator inductance is that of the machine's own keys, as that of a "
       "no-load test is at rated voltage; 0: they hold for small fluxes; counts where knee_wb is not 0"});
}

}  // namespace sextant
