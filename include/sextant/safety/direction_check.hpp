#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/safety/monitored_flux.hpp"

namespace sextant {

/// Decides whether the shaft turns as the speed is read or the other way round, as behind an encoder that is
/// wired in reverse or two motor cables that are exchanged. The rotor flux of each direction follows from
/// currents and speed (`MonitoredFlux`), the reactive power of each flux is held against that of the voltage:
///   q = i_s × (u − R_s i_s − σL_s di_s/dt),   q± = k_r i_s × dψ_r(±ω_m)/dt
/// (air-gap form of the reactive power; F. Z. Peng, T. Fukao, "Robust speed identification for
/// speed-sensorless vector control of induction motors", IEEE Trans. Ind. Appl. 30 (1994) 1234–1240). R_s and
/// the dead time of a bridge act along i_s and have no part in q. The reading is reversed where, as root mean
/// squares over τ_r,
///   |q − q₋| < |q₊ − q₋|/4   and   E < 3/4 |q₊ − q₋|
/// so that |q − q₊| > E, which is what errors of voltage, R_s, rotor parameters and a late speed make of q₊.
/// An open phase or a wrong current fits neither direction.
///
/// Not seen: a speed below `slowest`; a stator frequency near zero, or torque against which 2 p ω_m is small
/// beside the slip (d is within E); about 2 p ω_m τ_r < 1 in steady state. A direct current that builds up
/// the flux shows less than that, by the side to which the flux turns. Evaluated once in some 200 µs.
template <class T = double>
class DirectionCheck {
 public:
  struct Parameters {
    InductionMachineParameters<T> machine{};
    T current_noise{T(0.2)};  ///< standard deviation of a measured phase current [A]
    T slowest{T(0.5)};        ///< speed from which on the direction is decided [rad/s]
  };

  explicit DirectionCheck(const Parameters& p) noexcept
      : r_s_{p.machine.r_s},
        sigma_l_s_{p.machine.sigma_l_s()},
        k_r_{p.machine.k_r()},
        slowest_{p.slowest},
        // What the mean over `smooth` leaves of the noise of σL_s di/dt, three deviations.
        noise_{T(3) * p.machine.sigma_l_s() * p.current_noise / smooth},
        flux_share_{T(p.machine.pole_pairs) * p.machine.tau_r()},
        memory_{std::max(p.machine.tau_r(), T(2) * smooth)},
        forwards_{p.machine},
        backwards_{p.machine} {}

  /// A period of dt [s] with every leg driven: currents at its end [A], ∫u_x dt over it [V·s], link voltage
  /// [V], measured speed [rad/s].
  void step(const ThreePhase<T>& i, const ThreePhase<T>& volt_seconds, T u_dc, T omega_m, T dt) noexcept {
    volt_seconds_ += clarke(volt_seconds);
    u_dc_ = u_dc;
    advance(i, omega_m, dt);
  }

  /// The same with voltages that are not known: the fluxes go on.
  void step_without_voltage(const ThreePhase<T>& i, T omega_m, T dt) noexcept {
    is_known_ = false;
    advance(i, omega_m, dt);
  }

  /// dt [s] without a usable measurement: the gates are off, the speed is the last one.
  void coast(T dt) noexcept { step_without_voltage({}, omega_m_, dt); }

  /// Takes the limits of another one for the same machine; fluxes and means stay.
  constexpr void take_parameters(const DirectionCheck& from) noexcept {
    slowest_ = from.slowest_;
    noise_ = from.noise_;
  }

  /// Forgets what has been found; the fluxes go on.
  constexpr void restart() noexcept { means_ = {}; }

  /// True where currents and voltages show that the shaft turns against the measured speed.
  [[nodiscard]] constexpr bool is_reversed() const noexcept {
    return means_.rest < T(0.0625) * means_.difference && means_.error < T(0.5625) * means_.difference;
  }

 private:
  /// Reactive powers over 3/2, means over `smooth`. [VA]
  struct Powers {
    T q{};
    T forwards{};   ///< q₊
    T backwards{};  ///< q₋
  };
  /// Squares, means over τ_r. [VA²]
  struct Means {
    T rest{};        ///< of q − q₋
    T difference{};  ///< of q₊ − q₋
    T error{};       ///< of E
  };

  void advance(const ThreePhase<T>& i, T omega_m, T dt) noexcept {
    omega_m_ = omega_m;
    seconds_ += dt;
    if (seconds_ + T(0.5) * dt < block) return;
    const SpaceVector<T> i_s = clarke(i);
    const SpaceVector<T> mean_i = T(0.5) * (i_s + i_s_);
    const T forwards = power_of(forwards_, mean_i, omega_m);
    const T backwards = power_of(backwards_, mean_i, -omega_m);
    smooth_in(omega_m);
    if (is_known_) {
      const SpaceVector<T> emf_seconds =
          volt_seconds_ - (r_s_ * seconds_) * mean_i - sigma_l_s_ * (i_s - i_s_);
      smooth_in({cross(mean_i, emf_seconds) / seconds_, forwards, backwards});
      if (std::abs(omega_m) > slowest_) compare(mean_i);
    }
    i_s_ = i_s;
    volt_seconds_ = {};
    seconds_ = T(0);
    is_known_ = true;
  }

  /// k_r i × Δψ_r/Δt over the block.
  [[nodiscard]] T power_of(MonitoredFlux<T>& flux, SpaceVector<T> i_s, T omega_m) const noexcept {
    const SpaceVector<T> before = flux.psi_r();
    flux.step(i_s, omega_m, seconds_);
    return k_r_ * cross(i_s, flux.psi_r() - before) / seconds_;
  }

  void smooth_in(T omega_m) noexcept {
    const T share = std::min(T(1), seconds_ / smooth);
    mean_omega_m_ += share * (omega_m - mean_omega_m_);
    late_omega_m_ += share * (mean_omega_m_ - late_omega_m_);
  }

  void smooth_in(const Powers& now) noexcept {
    const T share = std::min(T(1), seconds_ / smooth);
    mean_.q += share * (now.q - mean_.q);
    mean_.forwards += share * (now.forwards - mean_.forwards);
    mean_.backwards += share * (now.backwards - mean_.backwards);
  }

  void compare(SpaceVector<T> i_s) noexcept {
    const T i_squared = dot(i_s, i_s);
    const T share = std::min(T(1), seconds_ / memory_);
    const T rest = mean_.q - mean_.backwards;
    const T difference = mean_.forwards - mean_.backwards;
    const T voltage = voltage_share * u_dc_ + noise_;
    const T of_r_s = r_s_share * r_s_;
    // A reading that is late by `smooth` errs by this much, and the slip p times as much.
    const T late = std::abs(mean_omega_m_ - late_omega_m_);
    // By a relative error of τ_r, q₊ errs by twice as much times the square of the sine between i_s and ψ_r.
    const T across = cross(forwards_.psi_r(), i_s);
    const T product = dot(forwards_.psi_r(), forwards_.psi_r()) * i_squared;
    const T square_of_sine = product > T(0) ? across * across / product : T(0);
    const T of_rotor = (rotor_share * (T(1) + T(2) * square_of_sine) + flux_share_ * late) * mean_.forwards;
    const T error = i_squared * (voltage * voltage + of_r_s * of_r_s * i_squared) + of_rotor * of_rotor;
    means_.rest += share * (rest * rest - means_.rest);
    means_.difference += share * (difference * difference - means_.difference);
    means_.error += share * (error - means_.error);
  }

  static constexpr T block = T(200e-6);         ///< time between two evaluations, at least a period [s]
  static constexpr T smooth = T(0.01);          ///< time constant of the powers [s]
  static constexpr T voltage_share = T(0.001);  ///< error across the current, of the link voltage [-]
  static constexpr T r_s_share = T(0.05);       ///< the same of R_s |i_s|: offsets and gains of phases [-]
  static constexpr T rotor_share = T(0.5);      ///< error of L_m, and of τ_r [-]

  T r_s_;
  T sigma_l_s_;
  T k_r_;
  T slowest_;
  T noise_;       ///< [V]
  T flux_share_;  ///< p τ_r: share of the flux that an error of the speed takes [s]
  T memory_;      ///< time constant of the means [s]
  MonitoredFlux<T> forwards_;
  MonitoredFlux<T> backwards_;
  SpaceVector<T> i_s_{};           ///< at the end of the last block [A]
  SpaceVector<T> volt_seconds_{};  ///< of the block so far [V·s]
  T seconds_{};                    ///< of the block so far [s]
  T u_dc_{};                       ///< [V]
  T omega_m_{};                    ///< last one measured [rad/s]
  bool is_known_{true};            ///< the voltage of the whole block is known
  Powers mean_{};
  T mean_omega_m_{};  ///< over `smooth` [rad/s]
  T late_omega_m_{};  ///< the same of this mean [rad/s]
  Means means_{};
};

}  // namespace sextant
