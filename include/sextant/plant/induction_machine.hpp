#pragma once

#include <algorithm>
#include <concepts>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"
#include "sextant/plant/electrical_rates.hpp"
#include "sextant/plant/flux_pair.hpp"
#include "sextant/plant/induction_magnetics.hpp"
#include "sextant/plant/induction_slopes.hpp"
#include "sextant/plant/iron_loss.hpp"
#include "sextant/plant/machine_evaluation.hpp"
#include "sextant/plant/machine_slopes.hpp"

namespace sextant {

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
/// Main flux and leakage saturate on request (`InductionMagnetics`). Iron loss on request (`IronLoss`)
/// shortens dpsi_r/dt; what is the rotor's current above is then that of rotor and iron, and `iron_branch`
/// parts them. Everything else is as written above.
template <class T = double>
class InductionMachine : public InductionMagnetics<T> {
 public:
  /// By default the magnetics are linear and without loss.
  constexpr explicit InductionMachine(const InductionMachineParameters<T>& parameters,
                                      const SaturationParameters<T>& saturation = {},
                                      const IronLossParameters<T>& iron_loss = {},
                                      const MagnetisingPoints<T>& points = {},
                                      const LeakageSaturation<T>& leakage = {}) noexcept
      : Magnetics{parameters, saturation, points, leakage},
        parameters_{parameters},
        pole_pairs_{T(parameters.pole_pairs)},
        angle_gain_{T(1.5) * pole_pairs_ * pole_pairs_ * parameters.k_r() / parameters.sigma_l_s()},
        iron_loss_{iron_loss, parameters},
        damping_{damping_of(parameters)} {}

  /// That of a plant, with the inverter's slope resistance in series.
  template <std::same_as<DrivePlantParameters<T>> Parameters>
  constexpr explicit InductionMachine(const Parameters& plant) noexcept
      : InductionMachine{plant.machine_in_series(), plant.saturation, plant.iron_loss, plant.points,
                         plant.leakage} {}

  /// Replaces the resistances [Ω]. Inductances, and the iron's own resistances, stay.
  constexpr void set_resistances(T r_s, T r_r) noexcept SEXTANT_NONBLOCKING {
    iron_loss_.scale_rotor_resistance(r_r / parameters_.r_r);
    parameters_.r_s = r_s;
    parameters_.r_r = r_r;
    damping_ = damping_of(parameters_);
  }

  /// The currents are linear in the flux linkages, and these move as `electrical_rates` has it.
  [[nodiscard]] constexpr bool is_linear() const noexcept SEXTANT_NONBLOCKING {
    return !this->saturates() && !iron_loss_.acts();
  }
  [[nodiscard]] constexpr bool has_iron_loss() const noexcept SEXTANT_NONBLOCKING {
    return iron_loss_.acts();
  }

  /// All of the machine at the flux linkages psi [Wb] under the stator voltage u_s [V] at the mechanical
  /// speed omega_m [rad/s].
  [[nodiscard, gnu::always_inline]] constexpr MachineEvaluation<T> evaluate(
      const FluxPair<T>& psi, SpaceVector<T> u_s, T omega_m) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> i_s = this->stator_current(psi.s, psi.r);
    SpaceVector<T> i_r = this->rotor_current(psi.s, psi.r);
    const SpaceVector<T> dpsi_r = rotor_flux_derivative(i_r, psi.r, omega_m);
    T tau_e = torque(psi.s, i_s);
    T iron_loss{};
    if (iron_loss_.acts()) [[unlikely]] {
      const IronBranch branch = iron_branch(i_r, psi.r, omega_m);
      i_r = branch.i_r;
      tau_e += branch.torque;
      iron_loss = branch.power;
    }
    const SpaceVector<T> dpsi_s = stator_flux_derivative(u_s, i_s);
    // By component: of a vector as a whole GCC stores what nobody reads.
    return {{{i_s.alpha, i_s.beta},
             {i_r.alpha, i_r.beta},
             tau_e,
             T(1.5) * parameters_.r_s * dot(i_s, i_s),
             T(1.5) * parameters_.r_r * dot(i_r, i_r),
             iron_loss},
            {{dpsi_s.alpha, dpsi_s.beta}, {dpsi_r.alpha, dpsi_r.beta}},
            this->magnetic_energy(psi.s, psi.r)};
  }
  /// Back-EMF behind the transient inductance, where the machine is at e. [V]
  [[nodiscard]] constexpr BackEmf<T> emf(const FluxPair<T>& psi,
                                         const MachineEvaluation<T>& e) const noexcept SEXTANT_NONBLOCKING {
    return Magnetics::emf(psi, e.dpsi.r, parameters_.r_s * e.i_s);
  }
  /// The slopes of all; the back-EMF counts as that of the machine without saturation.
  [[nodiscard]] MachineSlopes<T> slopes(const FluxPair<T>& psi,
                                        T omega_m) const noexcept SEXTANT_NONBLOCKING {
    return InductionSlopes<T>{parameters_, *this, iron_loss_}(psi, omega_m);
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
      return (T(1) - iron_share(f, psi_r)) * f;
    return f;
  }

  /// What the iron loss takes of the current of rotor and iron.
  struct IronBranch {
    SpaceVector<T> i_r{};  ///< what is left to the rotor, referred to the stator [A]
    T torque{};            ///< what it adds to that of `torque`, 3/2 p (i_fe × psi_R) [N·m]
    T power{};             ///< P_fe [W]
  };
  /// i_r: of `rotor_current`. For a machine with iron loss.
  [[nodiscard]] IronBranch iron_branch(SpaceVector<T> i_r, SpaceVector<T> psi_r,
                                       T omega_m) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> f = (pole_pairs_ * omega_m) * rotate_90(psi_r) - parameters_.r_r * i_r;
    const T share = iron_share(f, psi_r);
    const SpaceVector<T> i_fe = (share / parameters_.r_r) * f;  // of the rotor's turns
    return {i_r + i_fe, T(1.5) * pole_pairs_ * cross(i_fe, psi_r), T(1.5) * (T(1) - share) * dot(i_fe, f)};
  }

  /// tau_e = 3/2 p (psi_s × i_s), positive in the direction of positive speed. [N·m]
  [[nodiscard]] constexpr T torque(SpaceVector<T> psi_s,
                                   SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    return T(1.5) * pole_pairs_ * cross(psi_s, i_s);
  }
  /// dtau_e/dt without saturation and iron loss where the flux linkages move by dpsi [V]. [N·m/s]
  [[nodiscard]] constexpr T torque_slope(const FluxPair<T>& psi,
                                         const FluxPair<T>& dpsi) const noexcept SEXTANT_NONBLOCKING {
    return torque(dpsi.s, this->stator_current(psi.s, psi.r)) +
           torque(psi.s, this->stator_current(dpsi.s, dpsi.r));
  }

  /// How fast the fluxes settle at standstill at most, R_s di_s/dpsi_s + R_r/σL_r along psi_s, and what
  /// hysteresis adds; not below that of the machine without saturation. [1/s]
  [[nodiscard]] constexpr T damping(SpaceVector<T> psi_s,
                                    SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (this->saturates()) [[unlikely]]
      return saturated_damping(psi_s, psi_r);
    return damping_;
  }

  /// Of the machine without saturation and iron loss.
  [[nodiscard]] constexpr ElectricalRates<T> electrical_rates() const noexcept SEXTANT_NONBLOCKING {
    return {parameters_.r_s * this->inverse_sigma_l_s(), parameters_.r_s * this->coupling(),
            parameters_.r_r * this->coupling(), parameters_.r_r * this->inverse_sigma_l_r()};
  }

  [[nodiscard]] constexpr T pole_pairs() const noexcept SEXTANT_NONBLOCKING { return pole_pairs_; }  ///< [-]
  /// R_s. [Ω]
  [[nodiscard]] constexpr T stator_resistance() const noexcept SEXTANT_NONBLOCKING { return parameters_.r_s; }
  /// R_r. [Ω]
  [[nodiscard]] constexpr T rotor_resistance() const noexcept SEXTANT_NONBLOCKING { return parameters_.r_r; }
  /// The largest slope of the torque by the rotor's angle is |psi_s| |psi_r| times 3/2 p² k_r/σL_s; with
  /// saturation of the leakage its slope takes the place of the leakage inductance. [1/H]
  [[nodiscard]] constexpr T angle_gain(SpaceVector<T> psi_s,
                                       SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    if (this->has_saturated_leakage()) [[unlikely]]
      return angle_gain_ *
             (T(1) + (this->gamma() / this->coupling()) * this->largest_added_leakage(psi_s, psi_r));
    return angle_gain_;
  }

  [[nodiscard]] constexpr const InductionMachineParameters<T>& parameters() const noexcept
      SEXTANT_NONBLOCKING {
    return parameters_;
  }

 private:
  using Magnetics = InductionMagnetics<T>;

  /// R_s/σL_s + R_r/σL_r, and what hysteresis adds. [1/s]
  [[nodiscard]] constexpr T damping_of(const InductionMachineParameters<T>& parameters) const noexcept
      SEXTANT_NONBLOCKING {
    return parameters.r_s * this->inverse_sigma_l_s() + parameters.r_r * this->inverse_sigma_l_r() +
           iron_loss_.damping();
  }

  // These are apart and pure as those of `InductionMagnetics`.

  /// Of `IronLoss`; f: dpsi_r/dt without iron loss [V]. [-]
  [[nodiscard, gnu::pure, gnu::noinline]] T iron_share(SpaceVector<T> f, SpaceVector<T> psi_r) const noexcept
      SEXTANT_NONBLOCKING {
    return iron_loss_.share(f, psi_r);
  }
  [[nodiscard, gnu::pure, gnu::noinline]] T saturated_damping(
      SpaceVector<T> psi_s, SpaceVector<T> psi_r) const noexcept SEXTANT_NONBLOCKING {
    const T added = parameters_.r_s * std::max(T(0), this->added_along(psi_s, psi_r));
    return damping_ + added +
           parameters_.r_r * this->gamma() * this->gamma() * this->largest_added_leakage(psi_s, psi_r);
  }

  InductionMachineParameters<T> parameters_;
  T pole_pairs_;  ///< p [-]
  T angle_gain_;  ///< 3/2 p² k_r/σL_s [1/H]
  IronLoss<T> iron_loss_;
  T damping_;  ///< of `damping_of` [1/s]
};

}  // namespace sextant
