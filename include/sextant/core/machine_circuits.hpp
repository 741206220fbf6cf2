#pragma once

#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// Circuits of an induction machine that have all leakage in one place. They and the T circuit are one
/// machine: the rotor's turns are counted otherwise, psi_R = b psi_r and i_R = i_r/b, which changes nothing
/// at the terminals, in the torque or in the losses. Stator resistance, pole pairs and inertia are the same
/// in all three. Of the four inductive and rotor parameters of the T circuit the terminals show three; the
/// fourth is the ratio b.
enum class MachineCircuit { t, gamma, inverse_gamma };

/// Elements of a circuit with all leakage in one place; stator resistance, pole pairs and inertia as in the T
/// circuit.
template <class T = double>
struct LeakageCircuit {
  T l_m{};      ///< magnetising inductance [H]
  T l_sigma{};  ///< leakage inductance [H]
  T r_r{};      ///< rotor resistance [Ω]
};

/// The Γ circuit, all leakage on the rotor's side, of a machine: b = gamma = L_s/L_m,
///   L_M = L_s,   L_sigma = gamma L_ls + gamma² L_lr,   R_R = gamma² R_r
/// Source: G. R. Slemon, "Modelling of induction machines for electric drives", IEEE Trans. Ind. Appl. 25
/// (1989) 1126–1131.
template <class T>
[[nodiscard]] constexpr LeakageCircuit<T> gamma_circuit(const InductionMachineParameters<T>& m) noexcept {
  const T gamma = m.l_s() / m.l_m;
  return {m.l_s(), gamma * m.l_ls + gamma * gamma * m.l_lr, gamma * gamma * m.r_r};
}

/// The inverse-Γ circuit, all leakage on the stator's side, of a machine: b = k_r = L_m/L_r,
///   L_M = k_r L_m,   L_sigma = σL_s = L_ls + k_r L_lr,   R_R = k_r² R_r
/// Source: R. W. De Doncker, D. W. Novotny, "The universal field oriented controller", IEEE Trans. Ind. Appl.
/// 30 (1994) 92–100, where a is the ratio: a = L_m/L_r here, L_s/L_m in the Γ circuit.
template <class T>
[[nodiscard]] constexpr LeakageCircuit<T> inverse_gamma_circuit(
    const InductionMachineParameters<T>& m) noexcept {
  const T k_r = m.k_r();
  return {k_r * m.l_m, m.l_ls + k_r * m.l_lr, k_r * k_r * m.r_r};
}

/// The T circuit of a Γ circuit that has equal leakage inductances of stator and rotor, with the other
/// parameters of `m`: with c = 1 − σ = L_M/(L_M + L_sigma),
///   L_m = √c L_M,   L_ls = L_lr = L_M − L_m,   R_r = c R_R,   L_s/L_m = 1/√c
/// Source: as `gamma_circuit`, whose inverse this is.
template <class T>
[[nodiscard]] InductionMachineParameters<T> from_gamma(InductionMachineParameters<T> m,
                                                       const LeakageCircuit<T>& circuit) noexcept {
  const T sum = circuit.l_m + circuit.l_sigma;
  const T c = circuit.l_m / sum;
  const T root = std::sqrt(c);
  m.l_m = root * circuit.l_m;
  m.l_ls = c * circuit.l_sigma / (T(1) + root);  // the same, without a difference of large numbers
  m.l_lr = m.l_ls;
  m.r_r = c * circuit.r_r;
  return m;
}

/// The T circuit of an inverse-Γ circuit that has equal leakage inductances of stator and rotor, with the
/// other parameters of `m`: with c = 1 − σ = L_M/(L_M + L_sigma),
///   L_m = L_M/√c,   L_ls = L_lr = L_M + L_sigma − L_m,   R_r = R_R/c,   L_m/L_r = √c
/// Source: as `inverse_gamma_circuit`, whose inverse this is.
template <class T>
[[nodiscard]] InductionMachineParameters<T> from_inverse_gamma(InductionMachineParameters<T> m,
                                                               const LeakageCircuit<T>& circuit) noexcept {
  const T l_s = circuit.l_m + circuit.l_sigma;
  const T c = circuit.l_m / l_s;
  const T root = std::sqrt(c);
  m.l_m = root * l_s;
  m.l_ls = circuit.l_sigma / (T(1) + root);  // the same, without a difference of large numbers
  m.l_lr = m.l_ls;
  m.r_r = circuit.r_r / c;
  return m;
}

}  // namespace sextant
