#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "sextant/core/torque_range.hpp"
#include "sextant/drive/steady_state.hpp"

namespace sextant {

/// Available torque at a speed, when motoring and when regenerating.
template <class T = double>
struct AvailableTorque {
  T motoring{};                   ///< [N·m]
  T regenerating{};               ///< magnitude [N·m]
  bool holds_zero_torque{false};  ///< the voltage suffices for zero torque, so that the gates may be on

  /// The available range at this speed [rad/s]; its sign decides which direction is motoring.
  [[nodiscard]] constexpr TorqueRange<T> range(T omega_m) const noexcept {
    if (omega_m > T(0)) return {-regenerating, motoring};
    if (omega_m < T(0)) return {-motoring, regenerating};
    return {-motoring, motoring};
  }
};

/// The torque that machine and link can produce at a speed, at constant stator flux. Its steady state must
/// not need more voltage than the inverter has in every direction:
///   (R_s i_d)² + (R_s i_q + ω_e ψ)² ≤ (voltage_use · u_dc/√3)²,   ω_e = p ω_m + ω_slip
/// with i_d, i_q and ω_slip of `steady_state`. Braking needs less voltage than motoring, so that at high
/// speed only braking torques remain. Where these do not include zero torque, no torque is available: only
/// gates off would end the braking. A configured curve narrows the motoring torque further: full up to its
/// base speed, from there falling linearly to zero at its zero-torque speed.
template <class T = double>
class TorqueCapability {
 public:
  struct Parameters {
    static constexpr T unlimited = std::numeric_limits<T>::infinity();

    InductionMachineParameters<T> machine{};  ///< the controller's parameters of the machine
    T flux_reference{T(1.1)};                 ///< ψ [Wb]
    T voltage_use{T(0.98)};                   ///< share of u_dc/√3 that a torque may need [-]
    T reentry{T(0.03)};              ///< share of u_dc/√3 to spare before torque is available again [-]
    T torque{T(150)};                ///< largest magnitude, at any speed [N·m]
    T base_speed{unlimited};         ///< of the configured curve; unlimited: its zero-torque speed [rad/s]
    T zero_torque_speed{unlimited};  ///< of the configured curve; unlimited: no curve [rad/s]

    [[nodiscard]] const char* validate() const noexcept {
      if (const char* problem = machine.validate()) return problem;
      if (!(std::isfinite(flux_reference) && flux_reference > T(0))) {
        return "the flux reference must be above zero";
      }
      if (!(voltage_use > T(0) && voltage_use <= T(1))) return "the share of voltage must be in (0, 1]";
      if (!(reentry >= T(0) && reentry < voltage_use)) {
        return "the voltage to spare must be below the share of voltage";
      }
      if (!(std::isfinite(torque) && torque > T(0))) return "the available torque must be above zero";
      if (!(base_speed > T(0))) return "the base speed must be above zero";
      if (!(zero_torque_speed > T(0))) return "the zero-torque speed must be above zero";
      if (std::isfinite(base_speed) && !std::isfinite(zero_torque_speed)) {
        return "a base speed needs a zero-torque speed";
      }
      if (std::isfinite(base_speed) && !(zero_torque_speed > base_speed)) {
        return "the zero-torque speed must be above the base speed";
      }
      return nullptr;
    }
  };

  explicit TorqueCapability(const Parameters& parameters) noexcept
      : parameters_{parameters},
        base_speed_{std::min(parameters.base_speed, parameters.zero_torque_speed)},
        back_emf_{T(parameters.machine.pole_pairs) * parameters.flux_reference} {
    const T breakdown = breakdown_torque(parameters.machine, parameters.flux_reference);
    const T torque = std::min(parameters.torque, breakdown);
    const T last_slip = relative_slip(torque, breakdown);
    for (std::size_t k = 0; k <= last; ++k) {
      const auto s = steady_state(parameters.machine, parameters.flux_reference, last_slip * T(k) / T(last));
      const T u_d = parameters.machine.r_s * s.i_d;
      points_[k] = {.torque = s.torque,
                    .u_d_squared = u_d * u_d,
                    .u_q = parameters.machine.r_s * s.i_q + s.omega_slip * parameters.flux_reference};
    }
    points_[last].torque = torque;  // without a rounding error
  }

  /// Available torque at mechanical speed omega_m [rad/s] and link voltage u_dc [V]; zero while one of them
  /// is NaN. After zero, torque is available again once `reentry` of the voltage is to spare.
  [[nodiscard]] AvailableTorque<T> step(T omega_m, T u_dc) noexcept {
    const T spare = holds_zero_torque_ ? T(0) : parameters_.reentry;
    holds_zero_torque_ = holds_zero(emf(omega_m), limit(u_dc, parameters_.voltage_use - spare));
    return holds_zero_torque_ ? at(omega_m, u_dc) : AvailableTorque<T>{};
  }

  /// Available torque without the hysteresis of `reentry`.
  [[nodiscard]] AvailableTorque<T> at(T omega_m, T u_dc) const noexcept {
    const T e = emf(omega_m);
    const T u_squared = limit(u_dc, parameters_.voltage_use);
    if (!holds_zero(e, u_squared)) return {};
    return {.motoring = std::min(largest(e, T(1), u_squared), configured_curve(std::abs(omega_m))),
            .regenerating = largest(e, T(-1), u_squared),
            .holds_zero_torque = true};
  }

 private:
  /// One steady state of positive torque. With negative torque u_q has the other sign.
  struct Point {
    T torque;       ///< [N·m]
    T u_d_squared;  ///< (R_s i_d)² [V²]
    T u_q;          ///< R_s i_q + ω_slip ψ: the voltage across the flux without that of the speed [V]
  };
  static constexpr std::size_t last = 32;

  /// Voltage that the speed alone induces, p |ω_m| ψ. [V]
  [[nodiscard]] T emf(T omega_m) const noexcept { return back_emf_ * std::abs(omega_m); }

  /// Square of the available voltage; −1 without any. [V²]
  [[nodiscard]] static T limit(T u_dc, T use) noexcept {
    const T u = use * linear_voltage(u_dc);
    return u > T(0) ? u * u : T(-1);
  }

  /// Square of the needed voltage at point k; `sign` is 1 when motoring, -1 when braking. [V²]
  [[nodiscard]] T need(std::size_t k, T e, T sign) const noexcept {
    const T u_q = e + sign * points_[k].u_q;
    return points_[k].u_d_squared + u_q * u_q;
  }

  [[nodiscard]] bool holds_zero(T e, T u_squared) const noexcept { return need(0, e, T(1)) <= u_squared; }

  /// Largest torque of that sign for which the voltage suffices, where it suffices for zero torque. Between
  /// two points the square of the needed voltage is interpolated linearly, which errs high. [N·m]
  [[nodiscard]] T largest(T e, T sign, T u_squared) const noexcept {
    if (need(last, e, sign) <= u_squared) return points_[last].torque;
    std::size_t below = 0;
    for (std::size_t above = last; above - below > 1;) {
      const std::size_t middle = (below + above) / 2;
      (need(middle, e, sign) <= u_squared ? below : above) = middle;
    }
    const T from = need(below, e, sign);
    const T share = (u_squared - from) / (need(below + 1, e, sign) - from);
    return points_[below].torque + share * (points_[below + 1].torque - points_[below].torque);
  }

  /// Motoring torque of the configured curve. [N·m]
  [[nodiscard]] T configured_curve(T speed) const noexcept {
    if (speed <= base_speed_) return parameters_.torque;
    if (speed >= parameters_.zero_torque_speed) return T(0);
    const T range = parameters_.zero_torque_speed - base_speed_;
    return parameters_.torque * (parameters_.zero_torque_speed - speed) / range;
  }

  Parameters parameters_;
  T base_speed_;  ///< of the configured curve [rad/s]
  T back_emf_;    ///< p ψ [V·s/rad]
  std::array<Point, last + 1> points_{};
  bool holds_zero_torque_{true};
};

}  // namespace sextant
