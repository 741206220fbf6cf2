#pragma once

namespace sextant {

/// Coefficients of the electrical equations of a linear machine, which are linear at a given speed:
///   dpsi_s/dt = −a_ss psi_s + a_sr psi_r + u_s
///   dpsi_r/dt =  a_rs psi_s − a_rr psi_r + j omega_e psi_r,   omega_e = p omega_m
template <class T = double>
struct ElectricalRates {
  T ss{};  ///< R_s/σL_s [1/s]
  T sr{};  ///< R_s L_m/(L_s L_r − L_m²) [1/s]
  T rs{};  ///< R_r L_m/(L_s L_r − L_m²) [1/s]
  T rr{};  ///< R_r/σL_r [1/s]
};

}  // namespace sextant
