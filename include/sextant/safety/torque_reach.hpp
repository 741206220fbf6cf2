#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// What `TorqueReach` sees of one period.
template <class T = double>
struct ReachInputs {
  SpaceVector<T> psi_r{};  ///< rotor flux [Wb]
  SpaceVector<T> i_s{};    ///< stator current [A]
  T omega_m{};             ///< mechanical speed [rad/s]
  T u_dc{};                ///< link voltage [V]
};

/// The torque that machine and link have had time to reach: it follows the command as fast as the voltage
/// lets it. With ψ_s = σL_s i_s + k_r ψ_r and the machine's equations, stationary frame,
///   τ_e = K ψ_r × ψ_s,   K = 3/2 p k_r/(σL_s),   ω_r = p ω_m
///   dτ_e/dt = K (ψ_r × u_s − ω_r ψ_r · ψ_s) − τ_e (R_s/(σL_s) + 1/(σ τ_r))
/// Across a stator flux that turns and is held, every method has at least the mean of the switching table's
/// active vectors, which stand 30° to 90° from it, U = √3/π u_dc. Across the rotor flux, at the angle δ to
/// the stator flux, that is U cos δ:
///   K |ψ_r| (± U cos δ − ω_r ψ_s·ψ_r/|ψ_r|),   cos δ = ψ_s·ψ_r/(|ψ_s| |ψ_r|)
/// less the decay are the fastest rise and fall. δ counts as 45° at most, that of the breakdown torque,
/// beyond which no drive holds its torque. At the voltage limit the rise is slow, and below zero where the
/// link has sagged: then the torque falls until the flux has. Source: P. Vas, Sensorless Vector and Direct
/// Torque Control, Oxford 1998. Below a tenth of its reference the rotor flux counts as that tenth, so that a
/// machine that gets no current has had time as well.
///
/// Where the torque itself is nearer to the command, this follows it. It is the command after 2 σ τ_r without
/// a new one: within that time the drive lets the whole flux fall, and no lack of voltage lasts for longer.
template <class T = double>
class TorqueReach {
 public:
  /// flux_reference is that of the stator [Wb].
  constexpr TorqueReach(const InductionMachineParameters<T>& m, T flux_reference) noexcept
      : pole_pairs_{T(m.pole_pairs)}, least_flux_{T(0.1) * flux_reference} {
    set_machine(m);
  }

  /// Resistances and inductances from here on.
  constexpr void set_machine(const InductionMachineParameters<T>& m) noexcept {
    k_r_ = m.k_r();
    sigma_l_s_ = m.sigma_l_s();
    gain_ = T(1.5) * pole_pairs_ * k_r_ / sigma_l_s_;
    decay_ = m.r_s / sigma_l_s_ + m.l_s() / (sigma_l_s_ * m.tau_r());
    longest_ = T(2) * sigma_l_s_ * m.tau_r() / m.l_s();
  }

  /// One period of dt [s] with a command [N·m]; a change of it by more than `tolerance` [N·m] is a new one.
  void step(const ReachInputs<T>& now, T command, T tolerance, T dt) noexcept {
    if (std::abs(command - begun_by_) > tolerance) {
      begun_by_ = command;
      lag_s_ = T(0);
    }
    command_ = command;
    const T flux = std::sqrt(dot(now.psi_r, now.psi_r));
    const T psi = std::max(flux, least_flux_);
    const T along = k_r_ * flux + sigma_l_s_ * dot(now.psi_r, now.i_s) / psi;
    const T u = std::max(T(0), now.u_dc) * T(std::numbers::sqrt3 / std::numbers::pi) * cosine(now, along);
    const T e = pole_pairs_ * now.omega_m * along;
    const T fall = (gain_ * psi * (-u - e) - decay_ * torque_) * dt;
    const T rise = (gain_ * psi * (u - e) - decay_ * torque_) * dt;
    torque_ = std::clamp(command, torque_ + fall, torque_ + rise);
    lag_s_ += dt;
    if (lag_s_ > longest_) torque_ = command;
  }

  /// Follows the torque of the machine [N·m] where that is nearer to the command, by this share of the way;
  /// within `tolerance` [N·m] of the command that is reached.
  constexpr void follow(T torque, T tolerance, T share) noexcept {
    if (std::abs(torque - command_) <= tolerance) {
      torque_ = command_;
      lag_s_ = T(0);
      return;
    }
    const T nearer = std::clamp(torque, std::min(torque_, command_), std::max(torque_, command_));
    torque_ += share * (nearer - torque_);
  }

  /// No torque is made.
  constexpr void reset() noexcept { torque_ = command_ = begun_by_ = lag_s_ = T(0); }

  [[nodiscard]] constexpr T torque() const noexcept { return torque_; }  ///< [N·m]
  /// Time since the command was new or the torque there. [s]
  [[nodiscard]] constexpr T lag() const noexcept { return lag_s_; }

 private:
  /// cos δ of a stator flux, of which this much is along the rotor flux [Wb]; 1 without a flux. [-]
  [[nodiscard]] T cosine(const ReachInputs<T>& now, T along) const noexcept {
    const SpaceVector<T> psi_s = k_r_ * now.psi_r + sigma_l_s_ * now.i_s;
    const T square = dot(psi_s, psi_s);
    return square > T(0) ? std::max(T(std::numbers::sqrt2 / 2), along / std::sqrt(square)) : T(1);
  }

  T pole_pairs_;   ///< [-]
  T least_flux_;   ///< [Wb]
  T k_r_{};        ///< [-]
  T sigma_l_s_{};  ///< [H]
  T gain_{};       ///< K [1/H]
  T decay_{};      ///< R_s/(σL_s) + 1/(σ τ_r) [1/s]
  T longest_{};    ///< 2 σ τ_r [s]
  T torque_{};     ///< [N·m]
  T command_{};    ///< of the last step [N·m]
  T begun_by_{};   ///< the last new command [N·m]
  T lag_s_{};      ///< [s]
};

}  // namespace sextant
