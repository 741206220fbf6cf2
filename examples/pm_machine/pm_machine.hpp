// The plant's side of the example: the equations of the machine, a sextant::PlantMachine.
#pragma once

#include <cmath>

#include "pm_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/flux_pair.hpp"
#include "sextant/plant/inverse_inductance.hpp"
#include "sextant/plant/machine_evaluation.hpp"
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

  [[nodiscard]] sextant::MachineEvaluation<T> evaluate(const sextant::FluxPair<T>& psi, Vector u_s,
                                                       T omega_m) const noexcept SEXTANT_NONBLOCKING {
    const Vector d = sextant::direction(psi.r);
    const T psi_m = sextant::magnitude(psi.r);
    const T saliency = T(1) / p_.l_q - T(1) / p_.l_d;
    const Vector i_s = (T(1) / p_.l_q) * psi.s - (saliency * dot(psi.s, d) + psi_m / p_.l_d) * d;
    sextant::MachineEvaluation<T> e;
    e.i_s = i_s;
    e.tau_e = T(1.5) * pole_pairs() * cross(psi.s, i_s);
    e.stator_loss = T(1.5) * p_.r_s * dot(i_s, i_s);
    e.field_energy = T(0.75) * dot(psi.s - psi.r, i_s);  // of the currents, 3/4 (L_d i_d² + L_q i_q²)
    e.dpsi = {u_s - p_.r_s * i_s, (pole_pairs() * omega_m) * rotate_90(psi.r)};
    return e;
  }
  /// At constant current the flux turns with d,
  ///   e = (L_d − L_q) ((i_s · d′) d + (i_s · d) d′) + psi_m d′,   d′ = dpsi_r/dt / psi_m
  /// Along d the inverse inductance is 1/L_d, larger than 1/L_q by the square of the axis.
  [[nodiscard]] sextant::BackEmf<T> emf(const sextant::FluxPair<T>& psi,
                                        const sextant::MachineEvaluation<T>& at) const noexcept
      SEXTANT_NONBLOCKING {
    const Vector d = sextant::direction(psi.r);
    const Vector turn = (T(1) / p_.psi_m) * at.dpsi.r;
    const Vector e = (p_.l_d - p_.l_q) * (dot(at.i_s, turn) * d + dot(at.i_s, d) * turn) + at.dpsi.r;
    return {e, p_.r_s * at.i_s, std::sqrt(p_.l_q / p_.l_d - T(1)) * d};
  }
  /// psi_s = L_q i_s + ((L_d − L_q) i_d + psi_m) d
  [[nodiscard]] Vector stator_flux(Vector i_s, Vector psi_r) const noexcept SEXTANT_NONBLOCKING {
    const Vector d = sextant::direction(psi_r);
    return p_.l_q * i_s + ((p_.l_d - p_.l_q) * dot(i_s, d) + sextant::magnitude(psi_r)) * d;
  }
  /// The largest of any direction.
  [[nodiscard]] sextant::InverseInductance<T> inverse_inductance(Vector,
                                                                 Vector) const noexcept SEXTANT_NONBLOCKING {
    return {T(1) / p_.l_d, T(0), {}};
  }
  [[nodiscard]] T damping(Vector, Vector) const noexcept SEXTANT_NONBLOCKING { return p_.r_s / p_.l_d; }
  [[nodiscard]] T largest_inductance() const noexcept SEXTANT_NONBLOCKING { return p_.l_q; }
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
