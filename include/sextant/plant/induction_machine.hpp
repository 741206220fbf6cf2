#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/iron_loss.hpp"
#include "sextant/plant/iron_loss_parameters.hpp"

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
/// The main flux saturates on request (`SaturationCurve`): a current along psi_s is added to i_s, so that the
/// inverse transient inductance di_s/dpsi_s gets larger, and most along psi_s (`BackEmf`). Iron loss on
/// request (`IronLoss`) shortens dpsi_r/dt; what is the rotor's current above is then that of rotor and iron,
/// and `iron_branch` parts them. Everything else is as written above.
template <class T = double>
class InductionMachine {
 public:
  /// By default the magnetics are linear and without loss.
  constexpr explicit InductionMachine(const InductionMachineParameters<T>& parameters,
                                      const SaturationParameters<T>& saturation = {},
                                      const IronLossParameters<T>& iron_loss = {}) noexcept
      : parameters_{parameters},
        inverse_sigma_l_s_{T(1) / parameters.sigma_l_s()},
        inverse_sigma_l_r_{parameters.l_s() / (parameters.l_r() * parameters.sigma_l_s())},
        coupling_{parameters.k_r() / parameters.sigma_l_s()},
        k_r_{parameters.k_r()},
        pole_pairs_{T(parameters.pole_pairs)},
        iron_loss_{iron_loss, parameters},
        damping_{parameters.r_s * inverse_sigma_l_s_ + parameters.r_r * inverse_sigma_l_r_ +
                 iron_loss_.damping()},
        saturation_{saturation, parameters.l_s()} {}

  /// Replaces the resistances [Ω]. Inductances, and the iron's own resistances, stay.
  constexpr void set_resistances(T r_s, T r_r) noexcept SEXTANT_NONBLOCKING {
    iron_loss_.scale_rotor_resistance(r_r / parameters_.r_r);
    parameters_.r_s = r_s;
    parameters_.r_r = r_r;
    damping_ = r_s * inverse_sigma_l_s_ + r_r * inverse_sigma_l_r_ + iron_loss_.damping();
  }

  /// The currents are linear in the flux linkages, and these move as `electrical_rates` has it.
  [[nodiscard]] constexpr bool is_linear() const noexcept SEXTANT_NONBLOCKING {
    return !saturation_.acts() && !iron_loss_.acts();
  }
  [[nodiscard]] constexpr bool has_iron_loss() const noexcept SEXTANT_NONBLOCKING {
    return iron_loss_.acts();
  }

  /// i_s = psi_s / σL_s − L_m/(L_s L_r − L_m²) psi_r, and what saturation adds. [A]
  [[nodiscard]] constexpr SpaceVector<T> stator_current(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i_s = inverse_sigma_l_s_ * psi_s - coupling_ * psi_r;
    if (saturation_.acts()) [[unlikely]]
      return saturated_current(i_s, psi_s);
    return i_s;
  }

  /// i_r = psi_r / σL_r − L_m/(L_s L_r − L_m²) psi_s; with iron loss that of rotor and iron. [A]
  [[nodiscard]] constexpr SpaceVector<T> rotor_current(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    return inverse_sigma_l_r_ * psi_r - coupling_ * psi_s;
  }

  /// psi_s = σL_s i_s + k_r psi_r, less what saturation takes: the stator flux linkage that goes with a
  /// stator current. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> stator_flux(SpaceVector<T> i_s, SpaceVector<T> psi_r) const noexcept
      SEXTANT_NONBLOCKING {
    if (saturation_.acts()) [[unlikely]]
      return saturated_flux(i_s + coupling_ * psi_r);
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
  /// of 1/σL_s, and e = (di_s/dpsi_s)⁻¹ L_m/(L_s L_r − L_m²) dpsi_r/dt. [V]
  [[nodiscard]] constexpr BackEmf<T> emf(SpaceVector<T> dpsi_r, SpaceVector<T> psi_s,
                                         SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    if (saturation_.acts()) [[unlikely]]
      return saturated_emf(dpsi_r, psi_s, i_s);
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
    const T linear = T(0.75) * (dot(psi_s, i_s) + dot(psi_r, rotor_current(psi_s, psi_r)));
    return saturation_.acts() ? linear + T(1.5) * saturation_.added_energy(psi_s) : linear;
  }

  /// di_s/dpsi_s at a stator flux: what it is across psi_s, and by how much it is larger along psi_s.
  struct InverseInductance {
    T across{};       ///< [1/H]
    T added_along{};  ///< [1/H]
  };
  [[nodiscard]] constexpr InverseInductance inverse_inductance(SpaceVector<T> psi_s) const noexcept
      SEXTANT_NONBLOCKING {
    if (!saturation_.acts()) return {inverse_sigma_l_s_, T(0)};
    return {inverse_sigma_l_s_ + saturation_.added(psi_s), saturation_.added_along(psi_s)};
  }
  /// How fast the fluxes settle at standstill at most, R_s di_s/dpsi_s + R_r/σL_r along psi_s, and what
  /// hysteresis adds; not below that of the machine without saturation. [1/s]
  [[nodiscard]] constexpr T damping(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    if (saturation_.acts()) [[unlikely]]
      return saturated_damping(psi_s);
    return damping_;
  }
  /// The largest stator inductance, that of small fluxes. [H]
  [[nodiscard]] constexpr T largest_inductance() const noexcept SEXTANT_NONBLOCKING {
    return saturation_.largest_inductance_ratio() * parameters_.l_s();
  }

  /// Of the machine without saturation and iron loss.
  [[nodiscard]] constexpr ElectricalRates<T> electrical_rates() const noexcept SEXTANT_NONBLOCKING {
    return {parameters_.r_s * inverse_sigma_l_s_, parameters_.r_s * coupling_, parameters_.r_r * coupling_,
            parameters_.r_r * inverse_sigma_l_r_};
  }

  [[nodiscard]] constexpr T pole_pairs() const noexcept SEXTANT_NONBLOCKING { return pole_pairs_; }  ///< [-]
  /// R_s. [Ω]
  [[nodiscard]] constexpr T stator_resistance() const noexcept SEXTANT_NONBLOCKING { return parameters_.r_s; }
  /// The largest slope of the torque by the rotor's angle is |psi_s| |psi_r| times 3/2 p² k_r/σL_s. [1/H]
  [[nodiscard]] constexpr T angle_gain() const noexcept SEXTANT_NONBLOCKING {
    return T(1.5) * pole_pairs_ * pole_pairs_ * parameters_.k_r() / parameters_.sigma_l_s();
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
      SpaceVector<T> i_s, SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    return i_s + saturation_.added(psi_s) * psi_s;
  }

  [[nodiscard, gnu::noinline]] T saturated_damping(SpaceVector<T> psi_s) const noexcept SEXTANT_NONBLOCKING {
    const T added = saturation_.added(psi_s) + saturation_.added_along(psi_s);
    return damping_ + parameters_.r_s * std::max(T(0), added);
  }

  /// Solves (1/σL_s + g(|psi_s|)) psi_s = source by Newton's method on the magnitude. The left side is convex
  /// in it, so that from above the iteration falls to the solution, and has arrived where it falls no longer.
  [[nodiscard, gnu::noinline]] SpaceVector<T> saturated_flux(SpaceVector<T> source) const noexcept
      SEXTANT_NONBLOCKING {
    constexpr int most_iterations = 100;
    const T current = magnitude(source);
    T psi =
        std::min(current / (inverse_sigma_l_s_ + saturation_.added({})), saturation_.largest_flux(current));
    if (!(psi > T(0))) return {};
    const SpaceVector<T> along = (T(1) / current) * source;
    for (int n = 0; n < most_iterations; ++n) {
      const InverseInductance inverse = inverse_inductance({psi, T(0)});
      const T next = psi - (inverse.across * psi - current) / (inverse.across + inverse.added_along);
      if (!(next < psi)) break;
      psi = next;
    }
    return psi * along;
  }

  [[nodiscard, gnu::noinline]] BackEmf<T> saturated_emf(
      SpaceVector<T> dpsi_r, SpaceVector<T> psi_s, SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    const InverseInductance inverse = inverse_inductance(psi_s);
    const T square = dot(psi_s, psi_s);
    const SpaceVector<T> q =
        square > T(0) ? std::sqrt(inverse.added_along / (inverse.across * square)) * psi_s : SpaceVector<T>{};
    const SpaceVector<T> e = (coupling_ / inverse.across) * dpsi_r;
    return {e - (dot(q, e) / (T(1) + dot(q, q))) * q, parameters_.r_s * i_s, q};
  }

  InductionMachineParameters<T> parameters_;
  T inverse_sigma_l_s_;  ///< 1/σL_s [1/H]
  T inverse_sigma_l_r_;  ///< 1/σL_r [1/H]
  T coupling_;           ///< L_m/(L_s L_r − L_m²) [1/H]
  T k_r_;                ///< L_m/L_r [-]
  T pole_pairs_;         ///< p [-]
  IronLoss<T> iron_loss_;
  T damping_;  ///< R_s/σL_s + R_r/σL_r, and what hysteresis adds [1/s]
  SaturationCurve<T> saturation_;
};

}  // namespace sextant
