#pragma once

#include <complex>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// A machine of which no two factors coincide: k_r = 0.83, three pole pairs, unlike leakages and resistances.
inline InductionMachineParameters<double> unlike_machine() {
  return {
      .r_s = 0.31, .r_r = 0.47, .l_ls = 0.004, .l_lr = 0.009, .l_m = 0.045, .pole_pairs = 3, .inertia = 0.2};
}

template <class T>
InductionMachineParameters<T> in_scalar(const InductionMachineParameters<double>& m) {
  return {.r_s = T(m.r_s),
          .r_r = T(m.r_r),
          .l_ls = T(m.l_ls),
          .l_lr = T(m.l_lr),
          .l_m = T(m.l_m),
          .pole_pairs = m.pole_pairs,
          .inertia = T(m.inertia)};
}

inline SpaceVector<double> vector_of(std::complex<double> z) {
  return {z.real(), z.imag()};
}

/// Steady state of the T-equivalent circuit by its mesh equations, in complex amplitudes, from a stator
/// current:
///   0 = R_r i_r + j ω_slip (L_r i_r + L_m i_s),   u_s = R_s i_s + j ω_e (L_s i_s + L_m i_r)
/// A reference of its own: of the parameters it takes resistances, inductances and pole pairs, and no value
/// that is derived from them.
struct EquivalentCircuit {
  using Complex = std::complex<double>;

  double omega_e{};  ///< electrical [rad/s]
  Complex i_s{};     ///< [A]
  Complex i_r{};     ///< [A]
  Complex psi_s{};   ///< [Wb]
  Complex psi_r{};   ///< [Wb]
  Complex u_s{};     ///< [V]
  double torque{};   ///< [N·m]

  EquivalentCircuit(const InductionMachineParameters<double>& m, double omega_m, double omega_slip,
                    Complex current)
      : omega_e{m.pole_pairs * omega_m + omega_slip}, i_s{current} {
    const Complex j{0.0, 1.0};
    i_r = -j * omega_slip * m.l_m * i_s / (m.r_r + j * omega_slip * (m.l_lr + m.l_m));
    psi_s = (m.l_ls + m.l_m) * i_s + m.l_m * i_r;
    psi_r = m.l_m * i_s + (m.l_lr + m.l_m) * i_r;
    u_s = m.r_s * i_s + j * omega_e * psi_s;
    torque = 1.5 * m.pole_pairs * (std::conj(psi_s) * i_s).imag();
  }

  /// The same with a stator flux linkage of this magnitude, which is real.
  [[nodiscard]] static EquivalentCircuit of_flux(const InductionMachineParameters<double>& m, double omega_m,
                                                 double omega_slip, double psi) {
    const EquivalentCircuit one{m, omega_m, omega_slip, 1.0};
    return {m, omega_m, omega_slip, psi / one.psi_s};
  }
};

}  // namespace sextant
