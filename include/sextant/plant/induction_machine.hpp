#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/inverse_inductance.hpp"
#include "sextant/plant/iron_loss.hpp"
#include "sextant/plant/iron_loss_parameters.hpp"
#include "sextant/plant/leakage_saturation.hpp"
#include "sextant/plant/magnetising_points.hpp"
#include "sextant/plant/main_flux.hpp"

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
/// Stationary frame, amplitude-invariant space vectors, rotor quantities referred to the stator. Source:
/// P. Vas, "Sensorless Vector and Direct Torque Control", Oxford, 1998, chapter 1.
///
/// The main flux saturates on request (`SaturationCurve`, `MagnetisingTable`): a current along psi_s is added
/// to i_s, so that the inverse transient inductance di_s/dpsi_s gets larger, and most along psi_s
/// (`BackEmf`). So does the leakage flux (`LeakageSaturation`): with gamma = L_s/L_m a current i along psi_s
/// − gamma psi_r, the leakage flux of the Γ circuit, is added to i_s, and −gamma i to i_r. Both are gradients
/// of an energy that depends on a magnitude alone, so that the field stays without loss. Iron loss on request
/// (`IronLoss`) shortens dpsi_r/dt; what is the rotor's current above is then that of rotor and iron, and
/// `iron_branch` parts them. Everything else is as written above.
template <class T = double>
class InductionMachine {
 public:
  /// By default the magnetics are linear and without loss.
  constexpr explicit InductionMachine(const InductionMachineParameters<T>& parameters,
                                      const SaturationParameters<T>& saturation = {},
                                      const IronLossParameters<T>& iron_loss = {},
                                      const MagnetisingPoints<T>& points = {},
                                      const LeakageSaturation<T>& leakage = {}) noexcept
      : parameters_{parameters},
        inverse_sigma_l_s_{T(1) / parameters.sigma_l_s()},
        inverse_sigma_l_r_{parameters.l_s() / (parameters.l_r() * parameters.sigma_l_s())},
        coupling_{parameters.k_r() / parameters.sigma_l_s()},
        k_r_{parameters.k_r()},
        pole_pairs_{T(parameters.pole_pairs)},
        angle_gain_{T(1.5) * pole_pairs_ * pole_pairs_ * parameters.k_r() / parameters.sigma_l_s()},
        iron_loss_{iron_loss, parameters},
        damping_{parameters.r_s * inverse_sigma_l_s_ + parameters.r_r * inverse_sigma_l_r_ +
                 iron_loss_.damping()},
        saturates_{saturation.acts() || points.acts() || leakage.acts()},
        leakage_saturates_{leakage.acts()},
        gamma_{parameters.l_s() / parameters.l_m},
        main_{saturation, points, parameters.l_s()},
        leakage_{leakage.law(), gamma_ / coupling_} {}

  /// Replaces the resistances [Ω]. Inductances, and the iron's own resistances, stay.
  constexpr void set_resistances(T r_s, T r_r) noexcept SEXTANT_NONBLOCKING {
    iron_loss_.scale_rotor_resistance(r_r / parameters_.r_r);
    parameters_.r_s = r_s;
    parameters_.r_r = r_r;
    damping_ = r_s * inverse_sigma_l_s_ + r_r * inverse_sigma_l_r_ + iron_loss_.damping();
  }

  /// The currents are linear in the flux linkages, and these move as `electrical_rates` has it.
  [[nodiscard]] constexpr bool is_linear() const noexcept SEXTANT_NONBLOCKING {
    return !saturates_ && !iron_loss_.acts();
  }
  [[nodiscard]] constexpr bool has_saturated_leakage() const noexcept SEXTANT_NONBLOCKING {
    return leakage_saturates_;
  }
  [[nodiscard]] constexpr bool has_iron_loss() const noexcept SEXTANT_NONBLOCKING {
    return iron_loss_.acts();
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
    return parameters_.sigma_l_s() * i_s + k_r_ * psi_r;
  }

  /// dpsi_s/dt = u_s − R_s i_s. [V]
  [[nodiscard]] constexpr SpaceVector<T> stator_flux_derivative(
      SpaceVector<T> u_s, SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    return u_s - parameters_.r_s * i_s;
  }

  /// dpsi_r/dt = −R_r i_r + j p omega_m psi_r, omega_m mechanical, i_r of `rotor_current`; with iron loss
  /// less. [V]
  [[nodiscard]] constexpr SpaceVector<T> rotor_flux_derivative(SpaceVector<T> i_r, SpaceVector<T> psi_r,
                                                               T omega_m) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> f = (pole_pairs_ * omega_m) * rotate_90(psi_r) - parameters_.r_r * i_r;
    if (iron_loss_.acts()) [[unlikely]]
      return shortened(f, psi_r);
    return f;
  }

  /// What the iron loss takes of the current of rotor and iron.
  struct IronBranch {
    SpaceVector<T> i_r{};  ///< what is left to the rotor, referred to the stator [A]
    T torque{};            ///< what it adds to that of `torque`, 3/2 p (i_fe × psi_R) [N·m]
    T power{};             ///< P_fe [W]
  };
  /// i_r: of `rotor_current`. For a machine with iron loss.
  [[nodiscard, gnu::noinline]] IronBranch iron_branch(SpaceVector<T> i_r, SpaceVector<T> psi_r,
                                                      T omega_m) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> f = (pole_pairs_ * omega_m) * rotate_90(psi_r) - parameters_.r_r * i_r;
    const T share = iron_loss_.share(f, psi_r);
    const SpaceVector<T> i_fe = (share / parameters_.r_r) * f;  // of the rotor's turns
    return {i_r + i_fe, T(1.5) * pole_pairs_ * cross(i_fe, psi_r), T(1.5) * (T(1) - share) * dot(i_fe, f)};
  }
  /// Slopes of dpsi_r/dt by what it is without iron loss, f [V], for implicit integrators.
  [[nodiscard]] typename IronLoss<T>::Slopes iron_slopes(
      SpaceVector<T> f, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return iron_loss_.slopes(f, psi_r);
  }

  /// Back-EMF behind the transient inductance, e = k_r dpsi_r/dt. With saturation di_s/dpsi_s takes the place
  /// of 1/σL_s, and e = −(di_s/dpsi_s)⁻¹ di_s/dpsi_r dpsi_r/dt. [V]
  [[nodiscard]] constexpr BackEmf<T> emf(SpaceVector<T> dpsi_r, SpaceVector<T> psi_s, SpaceVector<T> psi_r,
                                         SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    if (saturates_) [[unlikely]]
      return saturated_emf(dpsi_r, psi_s, psi_r, i_s);
    return k_r_ * dpsi_r;
  }

  /// tau_e = 3/2 p (psi_s × i_s), positive in the direction of positive speed. [N·m]
  [[nodiscard]] constexpr T torque(SpaceVector<T> psi_s,
                                   SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    return T(1.5) * pole_pairs_ * cross(psi_s, i_s);
  }

  /// Energy stored in the magnetic field, 3/2 ∫ (i_s · dpsi_s + i_r · dpsi_r): without saturation
  /// 3/4 (psi_s · i_s + psi_r · i_r). [J]
  [[nodiscard]] constexpr T magnetic_energy(SpaceVector<T> psi_s,
                                            SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i_s = inverse_sigma_l_s_ * psi_s - coupling_ * psi_r;
    const SpaceVector<T> i_r = inverse_sigma_l_r_ * psi_r - coupling_ * psi_s;
    const T linear = T(0.75) * (dot(psi_s, i_s) + dot(psi_r, i_r));
    if (!saturates_) return linear;
    const T main = linear + T(1.5) * main_.added_energy(psi_s);
    return leakage_saturates_ ? main + T(1.5) * leakage_.added_energy(leakage_flux(psi_s, psi_r)) : main;
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
  /// How fast the fluxes settle at standstill at most, R_s di_s/dpsi_s + R_r/σL_r along psi_s, and what
  /// hysteresis adds; not below that of the machine without saturation. [1/s]
  [[nodiscard]] constexpr T damping(SpaceVector<T> psi_s,
                                    SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (saturates_) [[unlikely]]
      return saturated_damping(psi_s, psi_r);
    return damping_;
  }
  /// The largest stator inductance, that of small fluxes. [H]
  [[nodiscard]] constexpr T largest_inductance() const noexcept SEXTANT_NONBLOCKING {
    return main_.largest_inductance_ratio() * parameters_.l_s();
  }

  /// Of the machine without saturation and iron loss.
  [[nodiscard]] constexpr ElectricalRates<T> electrical_rates() const noexcept SEXTANT_NONBLOCKING {
    return {parameters_.r_s * inverse_sigma_l_s_, parameters_.r_s * coupling_, parameters_.r_r * coupling_,
            parameters_.r_r * inverse_sigma_l_r_};
  }

  [[nodiscard]] constexpr T pole_pairs() const noexcept SEXTANT_NONBLOCKING { return pole_pairs_; }  ///< [-]
  /// R_s. [Ω]
  [[nodiscard]] constexpr T stator_resistance() const noexcept SEXTANT_NONBLOCKING { return parameters_.r_s; }
  /// The largest slope of the torque by the rotor's angle is |psi_s| |psi_r| times 3/2 p² k_r/σL_s; with
  /// saturation of the leakage its slope takes the place of the leakage inductance. [1/H]
  [[nodiscard]] constexpr T angle_gain(SpaceVector<T> psi_s,
                                       SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (leakage_saturates_) [[unlikely]]
      return angle_gain_ * (T(1) + (gamma_ / coupling_) * largest_added_leakage(psi_s, psi_r));
    return angle_gain_;
  }

  [[nodiscard]] constexpr const InductionMachineParameters<T>& parameters() const noexcept
      SEXTANT_NONBLOCKING {
    return parameters_;
  }

 private:
  // These are apart, so that the equations of the linear machine stay small where they are inlined.

  /// f: dpsi_r/dt without iron loss. [V]
  [[nodiscard, gnu::noinline]] SpaceVector<T> shortened(SpaceVector<T> f, SpaceVector<T> psi_r) const noexcept
      SEXTANT_NONBLOCKING {
    return (T(1) - iron_loss_.share(f, psi_r)) * f;
  }

  /// i_s: of the linear machine. [A]
  [[nodiscard, gnu::noinline]] SpaceVector<T> saturated_current(
      SpaceVector<T> i_s, SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i = i_s + main_.added(psi_s) * psi_s;
    if (!leakage_saturates_) return i;
    const SpaceVector<T> psi_sigma = leakage_flux(psi_s, psi_r);
    return i + leakage_.added(psi_sigma) * psi_sigma;
  }
  /// i_r: of the linear machine. [A]
  [[nodiscard, gnu::noinline]] SpaceVector<T> saturated_rotor_current(
      SpaceVector<T> i_r, SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> psi_sigma = leakage_flux(psi_s, psi_r);
    return i_r - (gamma_ * leakage_.added(psi_sigma)) * psi_sigma;
  }
  /// Of `added_leakage`, along its axis. [1/H]
  [[nodiscard]] T largest_added_leakage(SpaceVector<T> psi_s,
                                        SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const InverseInductance<T> added = added_leakage(psi_s, psi_r);
    return added.across + added.added_along;
  }

  [[nodiscard, gnu::noinline]] T saturated_damping(SpaceVector<T> psi_s,
                                                   SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (!main_.is_table() && !leakage_saturates_) {
      const T added = main_.added(psi_s) + main_.added_along(psi_s);
      return damping_ + parameters_.r_s * std::max(T(0), added);
    }
    const InverseInductance<T> inverse = inverse_inductance(psi_s, psi_r);
    const T added = inverse.across + inverse.added_along - inverse_sigma_l_s_;
    return damping_ + parameters_.r_s * std::max(T(0), added) +
           parameters_.r_r * gamma_ * gamma_ * largest_added_leakage(psi_s, psi_r);
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
    SpaceVector<T> psi_s = parameters_.sigma_l_s() * i_s + k_r_ * psi_r;
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

  [[nodiscard, gnu::noinline]] BackEmf<T> saturated_emf(
      SpaceVector<T> dpsi_r, SpaceVector<T> psi_s, SpaceVector<T> psi_r,
      SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    const InverseInductance<T> inverse = inverse_inductance(psi_s, psi_r);
    const T square = dot(inverse.axis, inverse.axis);
    const SpaceVector<T> q = square > T(0)
                                 ? std::sqrt(inverse.added_along / (inverse.across * square)) * inverse.axis
                                 : SpaceVector<T>{};
    SpaceVector<T> e = (coupling_ / inverse.across) * dpsi_r;
    if (leakage_saturates_) e = e + (gamma_ / inverse.across) * added_leakage(psi_s, psi_r)(dpsi_r);
    return {e - (dot(q, e) / (T(1) + dot(q, q))) * q, parameters_.r_s * i_s, q};
  }

  InductionMachineParameters<T> parameters_;
  T inverse_sigma_l_s_;  ///< 1/σL_s [1/H]
  T inverse_sigma_l_r_;  ///< 1/σL_r [1/H]
  T coupling_;           ///< L_m/(L_s L_r − L_m²) [1/H]
  T k_r_;                ///< L_m/L_r [-]
  T pole_pairs_;         ///< p [-]
  T angle_gain_;         ///< 3/2 p² k_r/σL_s [1/H]
  IronLoss<T> iron_loss_;
  T damping_;       ///< R_s/σL_s + R_r/σL_r, and what hysteresis adds [1/s]
  bool saturates_;  ///< main flux or leakage
  bool leakage_saturates_;
  T gamma_;  ///< L_s/L_m [-]
  MainFlux<T> main_;
  SaturationCurve<T> leakage_;  ///< of the Γ circuit's leakage inductance, gamma (L_s L_r − L_m²)/L_m
};

}  // namespace sextant
