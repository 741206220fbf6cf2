// The plant's side of the example: the equations of the machine, a sextant::PlantMachine.
#pragma once

#include <cmath>

#include "pm_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/plant_machine.hpp"

namespace example {

/// A permanent-magnet machine in the stationary frame. psi_r is the flux of the magnets, of the magnitude
/// psi_m along d, and with psi_d = psi_s · d
///   i_s = psi_s/L_q − ((1/L_q − 1/L_d) psi_d + psi_m/L_d) d
///   dpsi_s/dt = u_s − R_s i_s,   dpsi_r/dt = j p omega_m psi_r,   tau_e = 3/2 p (psi_s × i_s)
/// Source: P. Vas, "Sensorless Vector and Direct Torque Control", Oxford, 1998, chapter 2.
template <class T = double>
class PmMachine {
 public:
  using Vector = sextant::SpaceVector<T>;

  explicit PmMachine(const PmParameters<T>& p) noexcept : p_{p} {}

  [[nodiscard]] Vector stator_current(Vector psi_s, Vector psi_r) const noexcept SEXTANT_NONBLOCKING {
    const Vector d = sextant::direction(psi_r);
    const T saliency = T(1) / p_.l_q - T(1) / p_.l_d;
    return (T(1) / p_.l_q) * psi_s - (saliency * dot(psi_s, d) + sextant::magnitude(psi_r) / p_.l_d) * d;
  }
  [[nodiscard]] Vector rotor_current(Vector, Vector) const noexcept SEXTANT_NONBLOCKING { return {}; }
  /// psi_s = L_q i_s + ((L_d − L_q) i_d + psi_m) d
  [[nodiscard]] Vector stator_flux(Vector i_s, Vector psi_r) const noexcept SEXTANT_NONBLOCKING {
    const Vector d = sextant::direction(psi_r);
    return p_.l_q * i_s + ((p_.l_d - p_.l_q) * dot(i_s, d) + sextant::magnitude(psi_r)) * d;
  }
  [[nodiscard]] Vector stator_flux_derivative(Vector u_s, Vector i_s) const noexcept SEXTANT_NONBLOCKING {
    return u_s - p_.r_s * i_s;
  }
  [[nodiscard]] Vector rotor_flux_derivative(Vector, Vector psi_r,
                                             T omega_m) const noexcept SEXTANT_NONBLOCKING {
    return (pole_pairs() * omega_m) * rotate_90(psi_r);
  }
  /// At constant current the flux turns with d, which is the direction of psi_s − L_q i_s:
  ///   e = (L_d − L_q) ((i_s · d′) d + (i_s · d) d′) + psi_m d′,   d′ = dpsi_r/dt / psi_m
  /// Along d the inverse inductance is 1/L_d, larger than 1/L_q by the square of the axis.
  [[nodiscard]] sextant::BackEmf<T> emf(Vector dpsi_r, Vector psi_s, Vector,
                                        Vector i_s) const noexcept SEXTANT_NONBLOCKING {
    const Vector d = sextant::direction(psi_s - p_.l_q * i_s);
    const Vector turn = (T(1) / p_.psi_m) * dpsi_r;
    const Vector e = (p_.l_d - p_.l_q) * (dot(i_s, turn) * d + dot(i_s, d) * turn) + dpsi_r;
    return {e, p_.r_s * i_s, std::sqrt(p_.l_q / p_.l_d - T(1)) * d};
  }
  [[nodiscard]] T torque(Vector psi_s, Vector i_s) const noexcept SEXTANT_NONBLOCKING {
    return T(1.5) * pole_pairs() * cross(psi_s, i_s);
  }
  /// Of the currents, 3/4 (L_d i_d² + L_q i_q²). [J]
  [[nodiscard]] T magnetic_energy(Vector psi_s, Vector psi_r) const noexcept SEXTANT_NONBLOCKING {
    const Vector i_s = stator_current(psi_s, psi_r);
    return T(0.75) * dot(psi_s - psi_r, i_s);
  }

  [[nodiscard]] bool is_linear() const noexcept SEXTANT_NONBLOCKING { return false; }
  [[nodiscard]] bool has_iron_loss() const noexcept SEXTANT_NONBLOCKING { return false; }
  struct IronBranch {
    Vector i_r{};
    T torque{};
    T power{};
  };
  [[nodiscard]] IronBranch iron_branch(Vector, Vector, T) const noexcept SEXTANT_NONBLOCKING { return {}; }
  /// The largest of any direction.
  struct InverseInductance {
    T across{};
    T added_along{};
  };
  [[nodiscard]] InverseInductance inverse_inductance(Vector, Vector) const noexcept SEXTANT_NONBLOCKING {
    return {T(1) / p_.l_d, T(0)};
  }
  [[nodiscard]] T damping(Vector, Vector) const noexcept SEXTANT_NONBLOCKING { return p_.r_s / p_.l_d; }
  [[nodiscard]] T largest_inductance() const noexcept SEXTANT_NONBLOCKING { return p_.l_q; }
  [[nodiscard]] sextant::ElectricalRates<T> electrical_rates() const noexcept SEXTANT_NONBLOCKING {
    return {};
  }
  [[nodiscard]] T pole_pairs() const noexcept SEXTANT_NONBLOCKING { return T(p_.pole_pairs); }
  [[nodiscard]] T stator_resistance() const noexcept SEXTANT_NONBLOCKING { return p_.r_s; }
  /// Of magnets and saliency, while the stator flux is no larger than that of the magnets.
  [[nodiscard]] T angle_gain(Vector, Vector) const noexcept SEXTANT_NONBLOCKING {
    return T(1.5) * pole_pairs() * pole_pairs() * (T(2) / p_.l_d - T(1) / p_.l_q);
  }

 private:
  PmParameters<T> p_;
};

static_assert(sextant::PlantMachine<PmMachine<double>, double>);

}  // namespace example
