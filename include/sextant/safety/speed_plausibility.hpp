#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Compares the measured speed with that at which the rotor flux turns, from voltages and currents alone:
///   e = u − R_s i − σL_s di/dt,   ψ = ∫(e − ω_c ψ) dt,
///   ω_m = (∠ψ/Δt − ω_slip) / p,   ω_slip = R_r τ_e / (3/2 p ψ_r²),   k_r ψ_r = ψ_s − σL_s i_s
/// (open-loop speed estimator; P. Vas, Sensorless Vector and Direct Torque Control, 1998). The leak
/// ω_c takes drift and the unknown flux of a start on a turning machine away; it changes magnitude and phase
/// of ψ, not the frequency. An error of R_s does not change the frequency either. An error of R_r goes into
/// the slip, of which `slip_tolerance` is allowed for. τ_e and |ψ_s| are the controller's. Evaluated once in
/// some 200 µs, over the time for which the patterns acted; ∠ψ is the angle by which ψ has turned since then.
///
/// Not seen: with gates off, while ψ is smaller than a fifth of the flux reference (no flux, or a stator
/// frequency below about 0.2 ω_c) or than what the unknown of the voltage, two standard deviations of it, may
/// make of it, δu/ω_c, and in the `settle_ns` after these.
template <class T = double>
class SpeedPlausibility {
 public:
  struct Parameters {
    InductionMachineParameters<T> machine{};
    std::int32_t period_ns{25'000};  ///< control period [ns]
    T voltage_error{};               ///< of the stator voltage, a standard deviation [V]
  };

  explicit SpeedPlausibility(const Parameters& p) noexcept
      : sigma_l_s_{p.machine.sigma_l_s()},
        pole_pairs_{T(p.machine.pole_pairs)},
        torque_gain_{T(1.5) * pole_pairs_},
        slip_gain_{p.machine.k_r() * p.machine.k_r() * p.machine.r_r / torque_gain_},
        r_s_{p.machine.r_s},
        block_ns_{p.period_ns * std::max<std::int64_t>(1, block_ns / p.period_ns)},
        blocks_to_settle_{int(settle_ns / block_ns_)},
        smallest_flux_{T(2) * p.voltage_error / leak},
        nominal_{block_of(block_ns_)} {
    restart({});
  }

  /// The end of an interval of duration_ns [ns] in which every leg was driven: currents [A], ∫u_x dt over it
  /// [V·s], measured speed [rad/s], the controller's torque [N·m] and |ψ_s| [Wb], and the flux reference
  /// [Wb].
  void step(const ThreePhase<T>& i, const ThreePhase<T>& volt_seconds, T omega_m, T torque, T psi_s,
            T psi_ref, std::int64_t duration_ns) noexcept {
    volt_seconds_.a += volt_seconds.a;
    volt_seconds_.b += volt_seconds.b;
    volt_seconds_.c += volt_seconds.c;
    elapsed_ns_ += duration_ns;
    if (elapsed_ns_ < block_ns_) return;
    const Block block = elapsed_ns_ == block_ns_ ? nominal_ : block_of(elapsed_ns_);
    evaluate(block, clarke(i), omega_m, torque, psi_s, psi_ref);
    elapsed_ns_ = 0;
    volt_seconds_ = {};
  }

  /// An interval with gates off, or that does not count: i are the currents at its end [A].
  constexpr void restart(const ThreePhase<T>& i) noexcept {
    i_s_ = clarke(i);
    psi_ = {};
    volt_seconds_ = {};
    error_ = T(0);
    weight_ = T(0);
    slip_ = T(0);
    elapsed_ns_ = 0;
    blocks_left_ = blocks_to_settle_;
  }

  /// True where the measured speed is off by more than `limit` [rad/s].
  [[nodiscard]] constexpr bool is_off_by(T limit) const noexcept {
    return blocks_left_ == 0 &&
           std::abs(error_) > limit * pole_pairs_ * weight_ + slip_tolerance * std::abs(slip_);
  }

 private:
  /// Factors of a time between two evaluations.
  struct Block {
    T half_r_s{};  ///< R_s/2 times it [Ω·s]
    T keep{};      ///< share of ψ that the leak leaves, and [-]
    T gain{};      ///< of ∫e dt, by the trapezoidal rule [-]
    T inverse{};   ///< [1/s]
    T filter{};    ///< share of the way to a new value [-]
  };

  [[nodiscard]] Block block_of(std::int64_t ns) const noexcept {
    const T seconds = T(ns) * T(1e-9);
    const T half_leak = T(0.5) * leak * seconds;
    return {.half_r_s = T(0.5) * r_s_ * seconds,
            .keep = (T(1) - half_leak) / (T(1) + half_leak),
            .gain = T(1) / (T(1) + half_leak),
            .inverse = T(1) / seconds,
            .filter = std::min(T(1), seconds / (T(filter_ns) * T(1e-9)))};
  }

  void evaluate(const Block& block, SpaceVector<T> i_s, T omega_m, T torque, T psi_s, T psi_ref) noexcept {
    const SpaceVector<T> emf_seconds =
        clarke(volt_seconds_) - block.half_r_s * (i_s + i_s_) - sigma_l_s_ * (i_s - i_s_);
    const SpaceVector<T> psi = block.keep * psi_ + block.gain * emf_seconds;
    const T slip = slip_of(i_s, torque, psi_s);
    const T weight = dot(psi, psi);
    const T turned = std::atan2(cross(psi_, psi), dot(psi_, psi)) * block.inverse;
    const T error = (turned - pole_pairs_ * omega_m - slip) * weight;
    error_ += block.filter * (error - error_);
    weight_ += block.filter * (weight - weight_);
    slip_ += block.filter * (slip * weight - slip_);
    psi_ = psi;
    i_s_ = i_s;
    const T smallest = std::max(smallest_share * psi_ref, smallest_flux_);
    if (weight < smallest * smallest) {
      blocks_left_ = blocks_to_settle_;
    } else if (blocks_left_ > 0) {
      --blocks_left_;
    }
  }

  /// ω_slip by the rotor flux that belongs to torque, |ψ_s| and current. [rad/s]
  [[nodiscard]] T slip_of(SpaceVector<T> i_s, T torque, T psi_s) const noexcept {
    const T i_squared = dot(i_s, i_s);
    const T across = torque / torque_gain_;  // ψ_s × i_s
    const T along = std::sqrt(std::max(T(0), psi_s * psi_s * i_squared - across * across));
    const T psi_r_squared = psi_s * psi_s - T(2) * sigma_l_s_ * along + sigma_l_s_ * sigma_l_s_ * i_squared;
    return psi_r_squared > T(0) ? slip_gain_ * torque / psi_r_squared : T(0);
  }

  static constexpr T leak = T(150);                  ///< ω_c [rad/s]
  static constexpr std::int64_t block_ns = 200'000;  ///< time between two evaluations, at least a period [ns]
  static constexpr std::int64_t filter_ns = 1'500'000;   ///< time constant of the comparison [ns]
  static constexpr std::int64_t settle_ns = 40'000'000;  ///< with flux, until the result counts [ns]
  static constexpr T slip_tolerance = T(1);              ///< share of the slip, for errors of R_r [-]
  static constexpr T smallest_share = T(0.2);            ///< of the flux reference [-]

  T sigma_l_s_;
  T pole_pairs_;
  T torque_gain_;  ///< 3/2 p [-]
  T slip_gain_;    ///< k_r² R_r/(3/2 p) [Ω]
  T r_s_;
  std::int64_t block_ns_;  ///< between two evaluations: whole periods [ns]
  int blocks_to_settle_;
  T smallest_flux_;               ///< [Wb]
  Block nominal_;                 ///< of that time
  SpaceVector<T> i_s_{};          ///< at the end of the last block [A]
  SpaceVector<T> psi_{};          ///< [Wb]
  ThreePhase<T> volt_seconds_{};  ///< of the block so far [V·s]
  T error_{};                     ///< (ω − p ω_m − ω_slip) ψ², filtered [Wb²·rad/s]
  T weight_{};                    ///< ψ², filtered [Wb²]
  T slip_{};                      ///< ω_slip ψ², filtered [Wb²·rad/s]
  std::int64_t elapsed_ns_{};     ///< of the block so far [ns]
  int blocks_left_{};             ///< until the result counts [-]
};

}  // namespace sextant
