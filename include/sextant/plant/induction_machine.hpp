#pragma once

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Coefficients of the electrical equations, which are linear at a given speed:
///   dpsi_s/dt = −a_ss psi_s + a_sr psi_r + u_s
///   dpsi_r/dt =  a_rs psi_s − a_rr psi_r + j omega_e psi_r,   omega_e = p omega_m
template <class T = double>
struct ElectricalRates {
  T ss{};  ///< R_s/σL_s [1/s]
  T sr{};  ///< R_s L_m/(L_s L_r − L_m²) [1/s]
  T rs{};  ///< R_r L_m/(L_s L_r − L_m²) [1/s]
  T rr{};  ///< R_r/σL_r [1/s]
};

/// Equations of the squirrel-cage induction machine with the flux linkages psi_s, psi_r as states.
///
///   psi_s = L_s i_s + L_m i_r,   psi_r = L_m i_s + L_r i_r
///   dpsi_s/dt = u_s − R_s i_s
///   dpsi_r/dt = −R_r i_r + j p omega_m psi_r
///   tau_e = 3/2 p (psi_s × i_s)
///
/// Seen from its terminals the machine is a resistance, the transient inductance and a back-EMF:
///   u_s = R_s i_s + σL_s di_s/dt + e,   e = k_r dpsi_r/dt,   k_r = L_m/L_r
///
/// Stationary frame, amplitude-invariant space vectors, rotor quantities referred to the stator, linear
/// magnetics. Source: P. Vas, "Sensorless Vector and Direct Torque Control", Oxford, 1998, chapter 1.
template <class T = double>
class InductionMachine {
 public:
  /// The currents are linear in the flux linkages.
  static constexpr bool is_linear = true;

  constexpr explicit InductionMachine(const InductionMachineParameters<T>& parameters) noexcept
      : parameters_{parameters},
        inverse_sigma_l_s_{T(1) / parameters.sigma_l_s()},
        inverse_sigma_l_r_{parameters.l_s() / (parameters.l_r() * parameters.sigma_l_s())},
        coupling_{parameters.k_r() / parameters.sigma_l_s()},
        k_r_{parameters.k_r()},
        pole_pairs_{T(parameters.pole_pairs)} {}

  /// i_s = psi_s / σL_s − L_m/(L_s L_r − L_m²) psi_r. [A]
  [[nodiscard]] constexpr SpaceVector<T> stator_current(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return inverse_sigma_l_s_ * psi_s - coupling_ * psi_r;
  }

  /// i_r = psi_r / σL_r − L_m/(L_s L_r − L_m²) psi_s. [A]
  [[nodiscard]] constexpr SpaceVector<T> rotor_current(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return inverse_sigma_l_r_ * psi_r - coupling_ * psi_s;
  }

  /// psi_s = σL_s i_s + k_r psi_r: the stator flux linkage that goes with a stator current. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> stator_flux(SpaceVector<T> i_s, SpaceVector<T> psi_r) const noexcept
      SEXTANT_NONBLOCKING {
    return parameters_.sigma_l_s() * i_s + k_r_ * psi_r;
  }

  /// dpsi_s/dt = u_s − R_s i_s. [V]
  [[nodiscard]] constexpr SpaceVector<T> stator_flux_derivative(
      SpaceVector<T> u_s, SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    return u_s - parameters_.r_s * i_s;
  }

  /// dpsi_r/dt = −R_r i_r + j p omega_m psi_r, omega_m mechanical. [V]
  [[nodiscard]] constexpr SpaceVector<T> rotor_flux_derivative(SpaceVector<T> i_r, SpaceVector<T> psi_r,
                                                               T omega_m) const noexcept SEXTANT_NONBLOCKING {
    return (pole_pairs_ * omega_m) * rotate_90(psi_r) - parameters_.r_r * i_r;
  }

  /// Back-EMF behind the transient inductance, e = k_r dpsi_r/dt. [V]
  [[nodiscard]] constexpr SpaceVector<T> emf(SpaceVector<T> dpsi_r) const noexcept SEXTANT_NONBLOCKING {
    return k_r_ * dpsi_r;
  }

  /// tau_e = 3/2 p (psi_s × i_s), positive in the direction of positive speed. [N·m]
  [[nodiscard]] constexpr T torque(SpaceVector<T> psi_s,
                                   SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    return T(1.5) * pole_pairs_ * cross(psi_s, i_s);
  }

  /// Energy stored in the magnetic field, 3/4 (psi_s · i_s + psi_r · i_r). [J]
  [[nodiscard]] constexpr T magnetic_energy(SpaceVector<T> psi_s,
                                            SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return T(0.75) * (dot(psi_s, stator_current(psi_s, psi_r)) + dot(psi_r, rotor_current(psi_s, psi_r)));
  }

  [[nodiscard]] constexpr ElectricalRates<T> electrical_rates() const noexcept SEXTANT_NONBLOCKING {
    return {parameters_.r_s * inverse_sigma_l_s_, parameters_.r_s * coupling_, parameters_.r_r * coupling_,
            parameters_.r_r * inverse_sigma_l_r_};
  }

  [[nodiscard]] constexpr const InductionMachineParameters<T>& parameters() const noexcept
      SEXTANT_NONBLOCKING {
    return parameters_;
  }

 private:
  InductionMachineParameters<T> parameters_;
  T inverse_sigma_l_s_;  ///< 1/σL_s [1/H]
  T inverse_sigma_l_r_;  ///< 1/σL_r [1/H]
  T coupling_;           ///< L_m/(L_s L_r − L_m²) [1/H]
  T k_r_;                ///< L_m/L_r [-]
  T pole_pairs_;         ///< p [-]
};

}  // namespace sextant
