#pragma once

#include <cmath>

#include "sextant/core/description.hpp"

namespace sextant {

/// State of machine and shaft in which a plant begins, the gates off; at rest and without flux by default.
/// The stator carries no current, so that
///   psi_r = (ψ, 0),   psi_s = k_r psi_r,   k_r = L_m/L_r   (with saturation the psi_s at which i_s = 0).
/// While no diode conducts, ψ decays with τ_r = L_r/R_r and turns with the rotor. A load behind a driveline
/// turns with the motor, its shaft not twisted.
template <class T = double>
struct InitialState {
  T speed{};       ///< omega_m [rad/s]
  T rotor_flux{};  ///< ψ, along phase a [Wb]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!std::isfinite(speed)) return "the initial speed must be finite";
    return std::isfinite(rotor_flux) && rotor_flux >= T(0)
               ? nullptr
               : "the initial flux must be finite and not below zero";
  }
};

template <class T>
void describe(Description& d, InitialState<T>& p) {
  auto& [speed, rotor_flux] = p;
  d.number(
      "initial_speed_rad_s", speed,
      {"rad/s", -1e4, 1e4,
       "mechanical, with which a free shaft begins, and with it a vehicle or a load behind a driveline"});
  d.number("initial_flux_wb", rotor_flux,
           {"Wb", 0, 100,
            "rotor flux with which the machine begins, along phase a and without stator current: it decays "
            "with the rotor's time constant until the gates are on"});
}

}  // namespace sextant
