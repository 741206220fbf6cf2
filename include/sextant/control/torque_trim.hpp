#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/control/vector_torque.hpp"
#include "sextant/core/description.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// Default time constant of the trim of a method that takes the nearest of few vectors for a whole period.
/// [s] psi_ref [Wb], u_dc [V], period [s].
///
/// An active vector moves the flux in a period by the share  s = (2/3) u_dc t_period/ψ_ref  of it, and the
/// torque by up to ΔT = 2 s T_b, with the breakdown torque T_b = 3/4 p ψ_ref²/σL_s. The nearest vector leaves
/// up to half of that, s T_b. Until the trim has taken it away, it adds up to s T_b τ, which is to move the
/// mean torque of 20 ms by no more than 0.004 T_b, a hundredth of the default limit of torque:
///   s τ = 80 µs
/// and so 10 ms for the paper's machine at 25 µs. The vector leads the torque to T_ref + x but for an error,
/// so that with the gain g = t_period/(τ + t_period) the poles of the trim are at z = 1 − g, or, with a
/// period of actuation delay, at z² − z + g = 0. From three periods on, g ≤ 1/4, x does not oscillate in
/// either.
template <class T>
[[nodiscard]] constexpr T default_trim_time(T psi_ref, T u_dc, T period) noexcept {
  const T share = T(2.0 / 3.0) * u_dc * period / psi_ref;
  return std::max(T(3) * period, T(80e-6) / share);
}

/// Slow correction of the torque reference of a method that takes one of few patterns each period: what the
/// torque changes in a period is not what it lacks, further in the direction that the EMF drives it to, so
/// that the mean torque differs from the reference. The trim x is the integral of the difference, with the
/// mean of a period by the trapezoidal rule from the estimates at both of its ends:
///   dx/dt = (T_ref − (T_before + T)/2) / τ,   |x| ≤ ΔT = 3/2 p ψ_ref (2/3 u_dc)/σL_s · t_period
/// ΔT is what an active vector changes of the torque in a period. A change of T_ref passes at once, and one
/// of ψ_ref or u_dc leaves the share x/ΔT: what few vectors leave of the torque goes with what they change of
/// it, so that a sag of the link leaves less to integrate anew.
///
/// The trim holds its value from a period in which the torque is further than 2 ΔT from T_ref + x, as after a
/// step of T_ref or where the link voltage does not suffice, until the torque has crossed T_ref + x or stands
/// between it and T_ref, whereto the trim alone drives it, or the method rests short of it.
template <class T = double>
class TorqueTrim {
 public:
  struct Parameters {
    T time_constant{T(0.01)};  ///< τ; 0: no trim [s]

    static constexpr const char* key = "torque_trim_ms";
    static constexpr Quantity quantity{
        "ms", 0, 1e4,
        "time constant with which the torque reference is trimmed until the mean of the estimated torque "
        "meets the command; 0: not trimmed",
        Changes::always};

    /// Of a method whose trim has the same time constant with every machine.
    friend void describe(Description& d, Parameters& p) {
      auto& [tau] = p;
      d.number(key, {tau, 1e-3}, quantity);
    }
    /// Of one where it follows from flux reference, link and period.
    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      auto& [tau] = p;
      d.defaulted(key, {tau, 1e-3}, {tau, by_default.time_constant}, quantity,
                  "no usable time constant follows from flux reference, link and control period");
    }

    [[nodiscard]] const char* validate() const noexcept {
      const bool good = std::isfinite(time_constant) && time_constant >= T(0);
      return good ? nullptr : "the time constant of the torque trim must not be below zero";
    }
  };

  /// period: the control period. [s]
  constexpr TorqueTrim(const Parameters& parameters, const InductionMachineParameters<T>& machine,
                       T period) noexcept {
    if (!(parameters.time_constant > T(0))) return;
    gain_ = period / (parameters.time_constant + period);
    limit_gain_ = vector_torque(machine, T(1), T(1), period);
  }

  /// One period in which the torque is to follow its reference: T_ref and the estimate T [N·m], ψ_ref [Wb]
  /// and u_dc [V]. rests: a zero vector was taken for the period before, as no active one led nearer to the
  /// references, or as the torque was within its band. Returns T_ref + x. [N·m]
  constexpr T step(T reference, T torque, T psi_ref, T u_dc, bool rests) noexcept {
    const T limit = limit_gain_ * psi_ref * u_dc;
    const T error = reference + share_ * limit - torque;
    const bool is_between = error * (reference - torque) < T(0);
    const bool begins = rests || is_between || error * error_before_ < T(0);
    follows_ = std::abs(error) < T(2) * limit && (follows_ || begins);
    if (follows_) {
      const T missing = gain_ * (reference - T(0.5) * (torque_before_ + torque));
      share_ = std::max(T(-1), std::min(T(1), share_ + missing / limit));
    }
    value_ = share_ * limit;
    torque_before_ = torque;
    error_before_ = error;
    return reference + value_;
  }

  /// False with a time constant of zero.
  [[nodiscard]] constexpr bool trims() const noexcept { return gain_ > T(0); }
  [[nodiscard]] constexpr T value() const noexcept { return value_; }  ///< x [N·m]

  /// Takes the time constant of another one for the same machine and period; the trim stays, with none it
  /// goes.
  constexpr void take_parameters(const TorqueTrim& from) noexcept {
    gain_ = from.gain_;
    limit_gain_ = from.limit_gain_;
    if (!trims()) reset();
  }

  /// To be called while the torque follows no reference.
  constexpr void reset() noexcept {
    share_ = T(0);
    value_ = T(0);
    error_before_ = T(0);
    follows_ = false;
  }

 private:
  T gain_{};           ///< of the sampled integral, t_period/(τ + t_period), below 1 with any τ [-]
  T limit_gain_{};     ///< ΔT/(ψ_ref u_dc) = p t_period/σL_s [N·m/(Wb·V)]
  T share_{};          ///< x/ΔT [-]
  T value_{};          ///< x [N·m]
  T torque_before_{};  ///< estimate at the beginning of the period [N·m]
  T error_before_{};   ///< T_ref + x − T there; 0 after a reset [N·m]
  bool follows_{false};
};

}  // namespace sextant
