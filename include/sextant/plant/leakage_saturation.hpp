#pragma once

#include <cmath>

#include "sextant/core/description.hpp"
#include "sextant/core/saturation_parameters.hpp"

namespace sextant {

/// Saturation of the leakage flux; none by default. The leakage inductance of the Γ circuit, all leakage on
/// the rotor's side, depends on the leakage flux linkage psi_sigma = psi_s − psi_R as
///   L_sigma(psi) = L_sigma_u / (1 + (psi/psi_k)^S)
/// with L_sigma_u the one of the machine's parameters. It stands for the tooth tips and for closed slots of a
/// rotor. Source: T. Tuovinen, M. Hinkkanen, J. Luomi, "Modeling of saturation due to main and leakage flux
/// interaction in induction machines", IEEE Trans. Ind. Appl. 46 (2010) 937–945, without the interaction.
template <class T = double>
struct LeakageSaturation {
  T knee{};         ///< psi_k, where L_sigma is half of what it is at small currents; 0: no saturation [Wb]
  int exponent{2};  ///< S [-]

  friend constexpr bool operator==(const LeakageSaturation&, const LeakageSaturation&) noexcept = default;

  [[nodiscard]] constexpr bool acts() const noexcept { return knee > T(0); }

  /// The same law as of a main flux.
  [[nodiscard]] constexpr SaturationParameters<T> law() const noexcept { return {knee, exponent, T(0)}; }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(knee) && knee >= T(0)))
      return "the knee of the leakage's saturation must be finite and not below zero";
    if (law().validate() != nullptr) return "the exponent of the leakage's saturation must be from 2 to 20";
    return nullptr;
  }
};

template <class T>
void describe(Description& d, LeakageSaturation<T>& p) {
  auto& [knee, exponent] = p;
  d.number("knee_wb", knee,
           {"Wb", 0, 1e3,
            "leakage flux linkage of the Γ circuit, about leakage inductance times rotor current, at which "
            "its leakage inductance has fallen to half of that of the machine's keys: L_sigma/(1 + "
            "(psi_sigma/knee_wb)^exponent); 0: it does not saturate"});
  d.integer("exponent", exponent, "", SaturationParameters<T>::smallest_exponent,
            SaturationParameters<T>::largest_exponent,
            "of the same, how sharp the knee is; counts where knee_wb is not 0");
}

}  // namespace sextant
