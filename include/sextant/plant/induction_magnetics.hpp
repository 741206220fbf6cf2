#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/flux_pair.hpp"
#include "sextant/plant/inverse_inductance.hpp"
#include "sextant/plant/leakage_saturation.hpp"
#include "sextant/plant/magnetising_points.hpp"
#include "sextant/plant/main_flux.hpp"

namespace sextant {

/// Currents, energy and back-EMF of an induction machine by its flux linkages,
///   psi_s = L_s i_s + L_m i_r,   psi_r = L_m i_s + L_r i_r
/// in the stationary frame, rotor quantities referred to the stator.
///
/// The main flux saturates on request (`SaturationCurve`, `MagnetisingTable`): a current along psi_s is added
/// to i_s, so that the inverse transient inductance di_s/dpsi_s gets larger, and most along psi_s
/// (`BackEmf`). So does the leakage flux (`LeakageSaturation`): with gamma = L_s/L_m a current i along psi_s
/// − gamma psi_r, the leakage flux of the Γ circuit, is added to i_s, and −gamma i to i_r. Both are gradients
/// of an energy that depends on a magnitude alone, so that the field stays without loss.
template <class T = double>
class InductionMagnetics {
 public:
  /// By default linear.
  constexpr explicit InductionMagnetics(const InductionMachineParameters<T>& parameters,
                                        const SaturationParameters<T>& saturation = {},
                                        const MagnetisingPoints<T>& points = {},
                                        const LeakageSaturation<T>& leakage = {}) noexcept
      : l_s_{parameters.l_s()},
        sigma_l_s_{parameters.sigma_l_s()},
        inverse_sigma_l_s_{T(1) / parameters.sigma_l_s()},
        inverse_sigma_l_r_{parameters.l_s() / (parameters.l_r() * parameters.sigma_l_s())},
        coupling_{parameters.k_r() / parameters.sigma_l_s()},
        k_r_{parameters.k_r()},
        saturates_{saturation.acts() || points.acts() || leakage.acts()},
        leakage_saturates_{leakage.acts()},
        gamma_{parameters.l_s() / parameters.l_m},
        main_{saturation, points, parameters.l_s()},
        leakage_{leakage.law(), gamma_ / coupling_} {}

  /// Main flux or leakage saturate.
  [[nodiscard]] constexpr bool saturates() const noexcept SEXTANT_NONBLOCKING { return saturates_; }
  [[nodiscard]] constexpr bool has_saturated_leakage() const noexcept SEXTANT_NONBLOCKING {
    return leakage_saturates_;
  }

  /// i_s = psi_s / σL_s − L_m/(L_s L_r − L_m²) psi_r, and what saturation adds. [A]
  [[nodiscard]] constexpr SpaceVector<T> stator_current(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i_s = inverse_sigma_l_s_ * psi_s - coupling_ * psi_r;
    if (saturates_) [[unlikely]]
      return saturated_current(i_s, psi_s, psi_r);
    return i_s;
  }

  /// i_r = psi_r / σL_r − L_m/(L_s L_r − L_m²) psi_s, and what saturation of the leakage adds; with iron loss
  /// that of rotor and iron. [A]
  [[nodiscard]] constexpr SpaceVector<T> rotor_current(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i_r = inverse_sigma_l_r_ * psi_r - coupling_ * psi_s;
    if (leakage_saturates_) [[unlikely]]
      return saturated_rotor_current(i_r, psi_s, psi_r);
    return i_r;
  }

  /// psi_s = σL_s i_s + k_r psi_r, less what saturation takes: the stator flux linkage that goes with a
  /// stator current. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> stator_flux(SpaceVector<T> i_s, SpaceVector<T> psi_r) const noexcept
      SEXTANT_NONBLOCKING {
    if (saturates_) [[unlikely]]
      return main_.is_table() || leakage_saturates_ ? solved_flux(i_s, psi_r)
                                                    : saturated_flux(i_s + coupling_ * psi_r);
    return sigma_l_s_ * i_s + k_r_ * psi_r;
  }

  /// Back-EMF behind the transient inductance, e = k_r dpsi_r/dt; drop: R_s i_s [V]. With saturation
  /// di_s/dpsi_s takes the place of 1/σL_s, and e = −(di_s/dpsi_s)⁻¹ di_s/dpsi_r dpsi_r/dt. [V]
  [[nodiscard]] constexpr BackEmf<T> emf(const FluxPair<T>& psi, SpaceVector<T> dpsi_r,
                                         SpaceVector<T> drop) const noexcept SEXTANT_NONBLOCKING {
    if (saturates_) [[unlikely]]
      return saturated_emf(dpsi_r, psi.s, psi.r, drop);
    return k_r_ * dpsi_r;
  }

  /// Energy stored in the magnetic field, 3/2 ∫ (i_s · dpsi_s + i_r · dpsi_r): without saturation
  /// 3/4 (psi_s · i_s + psi_r · i_r). [J]
  [[nodiscard]] constexpr T magnetic_energy(SpaceVector<T> psi_s,
                                            SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i_s = inverse_sigma_l_s_ * psi_s - coupling_ * psi_r;
    const SpaceVector<T> i_r = inverse_sigma_l_r_ * psi_r - coupling_ * psi_s;
    const T linear = T(0.75) * (dot(psi_s, i_s) + dot(psi_r, i_r));
    if (saturates_) [[unlikely]]
      return saturated_energy(linear, psi_s, psi_r);
    return linear;
  }

  /// di_s/dpsi_s: with saturation of the main flux alone by the law larger along psi_s.
  [[nodiscard]] constexpr InverseInductance<T> inverse_inductance(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (!saturates_) return {inverse_sigma_l_s_, T(0), {}};
    const InverseInductance<T> main{inverse_sigma_l_s_ + main_.added(psi_s), main_.added_along(psi_s), psi_s};
    if (!main_.is_table() && !leakage_saturates_) return main;
    return main + added_leakage(psi_s, psi_r);
  }
  /// What saturation of the leakage adds to di_s/dpsi_s; zero without.
  [[nodiscard]] constexpr InverseInductance<T> added_leakage(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (!leakage_saturates_) return {};
    const SpaceVector<T> psi_sigma = leakage_flux(psi_s, psi_r);
    return {leakage_.added(psi_sigma), leakage_.added_along(psi_sigma), psi_sigma};
  }
  /// psi_s − gamma psi_r, the leakage flux linkage of the Γ circuit. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> leakage_flux(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return psi_s - gamma_ * psi_r;
  }
  /// L_s/L_m. [-]
  [[nodiscard]] constexpr T gamma() const noexcept SEXTANT_NONBLOCKING { return gamma_; }
  /// Of `added_leakage`, along its axis. [1/H]
  [[nodiscard]] T largest_added_leakage(SpaceVector<T> psi_s,
                                        SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const InverseInductance<T> added = added_leakage(psi_s, psi_r);
    return added.across + added.added_along;
  }
  /// What saturation adds to di_s/dpsi_s along its axis; below zero in the foot of a table. [1/H]
  [[nodiscard]] T added_along(SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (!main_.is_table() && !leakage_saturates_) return main_.added(psi_s) + main_.added_along(psi_s);
    const InverseInductance<T> inverse = inverse_inductance(psi_s, psi_r);
    return inverse.across + inverse.added_along - inverse_sigma_l_s_;
  }
  /// The largest stator inductance, that of small fluxes. [H]
  [[nodiscard]] constexpr T largest_inductance() const noexcept SEXTANT_NONBLOCKING {
    return main_.largest_inductance_ratio() * l_s_;
  }
  /// 1/σL_s. [1/H]
  [[nodiscard]] constexpr T inverse_sigma_l_s() const noexcept SEXTANT_NONBLOCKING {
    return inverse_sigma_l_s_;
  }
  /// 1/σL_r. [1/H]
  [[nodiscard]] constexpr T inverse_sigma_l_r() const noexcept SEXTANT_NONBLOCKING {
    return inverse_sigma_l_r_;
  }
  /// L_m/(L_s L_r − L_m²). [1/H]
  [[nodiscard]] constexpr T coupling() const noexcept SEXTANT_NONBLOCKING { return coupling_; }

 private:
  // These are apart, so that the equations of the linear machine stay small where they are inlined, and pure,
  // so that what nobody uses is not computed.

  /// i_s: of the linear machine. [A]
  [[nodiscard, gnu::pure, gnu::noinline]] SpaceVector<T> saturated_current(
      SpaceVector<T> i_s, SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i = i_s + main_.added(psi_s) * psi_s;
    if (!leakage_saturates_) return i;
    const SpaceVector<T> psi_sigma = leakage_flux(psi_s, psi_r);
    return i + leakage_.added(psi_sigma) * psi_sigma;
  }
  /// i_r: of the linear machine. [A]
  [[nodiscard, gnu::pure, gnu::noinline]] SpaceVector<T> saturated_rotor_current(
      SpaceVector<T> i_r, SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> psi_sigma = leakage_flux(psi_s, psi_r);
    return i_r - (gamma_ * leakage_.added(psi_sigma)) * psi_sigma;
  }
  /// linear: of the linear machine. [J]
  [[nodiscard, gnu::pure, gnu::noinline]] T saturated_energy(
      T linear, SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const T main = linear + T(1.5) * main_.added_energy(psi_s);
    return leakage_saturates_ ? main + T(1.5) * leakage_.added_energy(leakage_flux(psi_s, psi_r)) : main;
  }

  [[nodiscard, gnu::noinline]] BackEmf<T> saturated_emf(
      SpaceVector<T> dpsi_r, SpaceVector<T> psi_s, SpaceVector<T> psi_r,
      SpaceVector<T> drop) const noexcept SEXTANT_NONBLOCKING {
    const InverseInductance<T> inverse = inverse_inductance(psi_s, psi_r);
    const T square = dot(inverse.axis, inverse.axis);
    const SpaceVector<T> q = square > T(0)
                                 ? std::sqrt(inverse.added_along / (inverse.across * square)) * inverse.axis
                                 : SpaceVector<T>{};
    SpaceVector<T> e = (coupling_ / inverse.across) * dpsi_r;
    if (leakage_saturates_) e = e + (gamma_ / inverse.across) * added_leakage(psi_s, psi_r)(dpsi_r);
    return {e - (dot(q, e) / (T(1) + dot(q, q))) * q, drop, q};
  }

  /// Solves (1/σL_s + g(|psi_s|)) psi_s = source by Newton's method on the magnitude. The left side is convex
  /// in it, so that from above the iteration falls to the solution, and has arrived where it falls no longer.
  [[nodiscard, gnu::noinline]] SpaceVector<T> saturated_flux(SpaceVector<T> source) const noexcept
      SEXTANT_NONBLOCKING {
    constexpr int most_iterations = 100;
    const T current = magnitude(source);
    T psi = std::min(current / (inverse_sigma_l_s_ + main_.added({})), main_.curve().largest_flux(current));
    if (!(psi > T(0))) return {};
    const SpaceVector<T> along = (T(1) / current) * source;
    for (int n = 0; n < most_iterations; ++n) {
      const InverseInductance<T> inverse = inverse_inductance({psi, T(0)}, {});
      const T next = psi - (inverse.across * psi - current) / (inverse.across + inverse.added_along);
      if (!(next < psi)) break;
      psi = next;
    }
    return psi * along;
  }

  /// The stator flux linkage of i_s where the curve along psi_s is not convex, or the leakage saturates. The
  /// current is the gradient of a strictly convex energy, so that along each step of Newton's method its
  /// distance from i_s falls at first; the step is halved until it has fallen.
  [[nodiscard, gnu::noinline]] SpaceVector<T> solved_flux(
      SpaceVector<T> i_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    constexpr int most_iterations = 300, most_halvings = 40;
    SpaceVector<T> psi_s = sigma_l_s_ * i_s + k_r_ * psi_r;
    SpaceVector<T> rest = stator_current(psi_s, psi_r) - i_s;
    for (int n = 0; n < most_iterations; ++n) {
      SpaceVector<T> step = inverse_inductance(psi_s, psi_r).flux(rest);
      bool falls = false;
      for (int halvings = 0; halvings < most_halvings && !falls; ++halvings, step = T(0.5) * step) {
        const SpaceVector<T> next = psi_s - step;
        const SpaceVector<T> next_rest = stator_current(next, psi_r) - i_s;
        falls = dot(next_rest, next_rest) < dot(rest, rest);
        if (!falls) continue;
        psi_s = next;
        rest = next_rest;
      }
      if (!falls) break;
    }
    return psi_s;
  }

  T l_s_;                ///< [H]
  T sigma_l_s_;          ///< [H]
  T inverse_sigma_l_s_;  ///< 1/σL_s [1/H]
  T inverse_sigma_l_r_;  ///< 1/σL_r [1/H]
  T coupling_;           ///< L_m/(L_s L_r − L_m²) [1/H]
  T k_r_;                ///< L_m/L_r [-]
  bool saturates_;       ///< main flux or leakage
  bool leakage_saturates_;
  T gamma_;  ///< L_s/L_m [-]
  MainFlux<T> main_;
  SaturationCurve<T> leakage_;  ///< of the Γ circuit's leakage inductance, gamma (L_s L_r − L_m²)/L_m
};

}  // namespace sextant
