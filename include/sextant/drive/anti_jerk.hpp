#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/torque_range.hpp"

namespace sextant {

/// What a user may say of `AntiJerk`.
template <class T = double>
struct AntiJerkParameters {
  T gain{};         ///< g; 0: there is no correction [N·m·s/rad]
  T corner{T(1)};   ///< of the high-pass of the speed [Hz]
  T share{T(0.1)};  ///< largest correction, as a share of the limit of the torque command [-]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(gain) && gain >= T(0))) return "the gain must be finite and not below zero";
    if (!(std::isfinite(corner) && corner > T(0))) return "the corner frequency must be above zero";
    return share > T(0) && share <= T(1) ? nullptr : "the share of the torque must be in (0, 1]";
  }
  /// The same of a motor with that inertia [kg·m²] and control periods of period_s [s]. A gain makes a rate
  /// g/J of the motor's speed, beside which the delay of decision and torque, some two periods, must be
  /// short: at g/J = 1/(4 T) it costs 29° of phase.
  [[nodiscard]] const char* validate_with(T inertia, T period_s) const noexcept {
    return T(4) * gain * period_s <= inertia ? nullptr
                                             : "the gain of anti_jerk must be at most a quarter of the "
                                               "motor's inertia by the control period";
  }
};

template <class T>
void describe(Description& d, AntiJerkParameters<T>& p) {
  auto& [gain, corner, share] = p;
  d.number("gain_nm_s_rad", gain,
           {"N·m·s/rad", 0, 1e4,
            "torque against the high-passed measured speed, by which the drive damps a shaft that twists "
            "between motor and load; 0: none",
            Changes::always});
  d.number("corner_hz", corner,
           {"Hz", 0.01, 1e3,
            "corner of both high-passes of the speed, well below the frequency at which the shaft "
            "oscillates: below it the correction fades, and a constant acceleration makes none",
            Changes::always});
  d.number("share", share,
           {"", 1e-3, 1, "largest correction, as a share of command.torque_limit_nm", Changes::always});
}

/// Damps the oscillation of the motor against a load behind a soft shaft by a correction of the torque
/// reference,
///   Δτ = −g (s/(s + ω_c))² omega_m,   ω_c = 2π corner,
/// above ω_c a viscous friction at the motor that takes no torque from a constant speed or acceleration. Both
/// high-passes are integrated by backward Euler. Source: active damping by the motor's speed, as in
/// U. Kiencke, L. Nielsen, "Automotive Control Systems", 2nd ed., Springer, 2005, chapter 9.
template <class T = double>
class AntiJerk {
 public:
  using Parameters = AntiJerkParameters<T>;

  /// The parameters must be valid.
  constexpr explicit AntiJerk(const Parameters& p) noexcept
      : gain_{p.gain}, time_constant_{T(1) / (T(2) * std::numbers::pi_v<T> * p.corner)}, share_{p.share} {}

  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING { return gain_ > T(0); }

  /// Takes the parameters of another one; the high-passes go on.
  constexpr void take_parameters(const AntiJerk& from) noexcept {
    gain_ = from.gain_;
    time_constant_ = from.time_constant_;
    share_ = from.share_;
  }

  /// The correction at a measured speed [rad/s], dt [s] after the one before. The first speed counts as one
  /// that has long been there. [N·m]
  constexpr T step(T omega_m, T dt) noexcept SEXTANT_NONBLOCKING {
    if (!started_) low_ = omega_m;
    started_ = true;
    const T weight = dt / (time_constant_ + dt);
    low_ += weight * (omega_m - low_);
    const T once = omega_m - low_;
    low_of_once_ += weight * (once - low_of_once_);
    return correction_ = -gain_ * (once - low_of_once_);
  }

  /// A torque reference within a range with the last correction, of at most the share of `full`; within the
  /// range too. A reference outside of the range, and one without correction, stays as it is. [N·m]
  [[nodiscard]] constexpr T corrected(T reference, T full,
                                      TorqueRange<T> range) const noexcept SEXTANT_NONBLOCKING {
    const T most = share_ * full;
    const T lowest = std::min(reference, range.lowest);
    const T highest = std::max(reference, range.highest);
    return std::clamp(reference + std::clamp(correction_, -most, most), lowest, highest);
  }

 private:
  T gain_;
  T time_constant_;  ///< 1/ω_c [s]
  T share_;
  T low_{};          ///< what the first high-pass takes away [rad/s]
  T low_of_once_{};  ///< the same of the second [rad/s]
  T correction_{};   ///< [N·m]
  bool started_{false};
};

}  // namespace sextant
