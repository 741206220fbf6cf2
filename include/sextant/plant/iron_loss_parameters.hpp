#pragma once

#include <cmath>

#include "sextant/core/description.hpp"

namespace sextant {

/// Iron loss of the machine; none by default. Of a field that turns with the electrical angular frequency
/// omega, the loss per phase is that of a resistance
///   R_fe(omega) = 1/(1/R_e + omega_h/(R_h |omega|))
/// across the voltage that the rotor flux linkage induces (`IronLoss`, which names the sources): eddy
/// currents lose power by the square of the frequency and of the flux, hysteresis by the frequency and the
/// square of the flux.
template <class T = double>
struct IronLossParameters {
  T eddy_resistance{};                          ///< R_e; 0: no eddy currents [Ω]
  T hysteresis_resistance{};                    ///< R_h, at omega_h; 0: no hysteresis [Ω]
  T hysteresis_frequency{T(314.159265358979)};  ///< omega_h, electrical; 50 Hz by default [rad/s]

  friend constexpr bool operator==(const IronLossParameters&, const IronLossParameters&) noexcept = default;

  [[nodiscard]] constexpr bool acts() const noexcept {
    return eddy_resistance > T(0) || hysteresis_resistance > T(0);
  }

  /// |i_fe| of hysteresis by the rotor flux linkage behind it, omega_h/R_h. [1/H]
  [[nodiscard]] constexpr T hysteresis() const noexcept {
    return hysteresis_resistance > T(0) ? hysteresis_frequency / hysteresis_resistance : T(0);
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto is_usable = [](T x) { return std::isfinite(x) && x >= T(0); };
    if (!is_usable(eddy_resistance))
      return "the eddy-current resistance of the iron loss must be finite and not below zero";
    if (!is_usable(hysteresis_resistance))
      return "the hysteresis resistance of the iron loss must be finite and not below zero";
    if (!(std::isfinite(hysteresis_frequency) && hysteresis_frequency > T(0)))
      return "the frequency of the hysteresis resistance must be finite and above zero";
    return nullptr;
  }

  /// nullptr where the machine loses its flux when no stator current flows, else what is wrong. largest_l_m:
  /// magnetising inductance of the inverse-Γ circuit, the largest one of a machine that saturates [H].
  [[nodiscard]] const char* validate_with(T largest_l_m) const noexcept {
    return hysteresis() * largest_l_m < T(1)
               ? nullptr
               : "the hysteresis resistance of the iron loss must be larger than the machine's magnetising "
                 "reactance at the same frequency, or its flux would stay without a current";
  }
};

template <class T>
void describe(Description& d, IronLossParameters<T>& p) {
  auto& [eddy_resistance, hysteresis_resistance, hysteresis_frequency] = p;
  d.number("eddy_ohm", eddy_resistance,
           {"ohm", 0, 1e9,
            "resistance per phase of the eddy currents in the iron, across the voltage that the rotor flux "
            "linkage induces, beside the magnetising inductance of the inverse-Γ circuit: a loss by "
            "frequency squared; of the machine alone: the drive's drive.iron_loss_resistance_ohm is a "
            "resistance at all frequencies; 0: none"});
  d.number("hysteresis_ohm", hysteresis_resistance,
           {"ohm", 0, 1e9,
            "the same of hysteresis, at the frequency at_rad_s and in proportion to the frequency: a loss by "
            "frequency; above the magnetising reactance there; 0: none"});
  d.number("at_rad_s", hysteresis_frequency,
           {"rad/s", 1e-3, 1e6,
            "electrical angular frequency at which hysteresis_ohm holds; counts where hysteresis_ohm is not "
            "0"});
}

}  // namespace sextant
