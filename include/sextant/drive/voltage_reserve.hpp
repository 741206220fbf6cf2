#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/steady_state.hpp"

namespace sextant {

/// What `VoltageReserve` sees of one period.
template <class T = double>
struct TorqueTracking {
  T reference{};        ///< torque reference [N·m]
  T torque{};           ///< estimated torque, without what over-modulation adds [N·m]
  T omega_m{};          ///< mechanical speed [rad/s]
  T u_dc{};             ///< link voltage [V]
  T flux_share{T(1)};   ///< flux reference as a share of the configured one [-]
  bool makes_torque{};  ///< the torque is controlled
  bool interrupted{};   ///< the gates were off in the meantime, as after missed periods
  bool limited{};       ///< the reference is what the drive limits it to
  bool slews{};         ///< the flux reference is on its way
};

/// Adapts the voltage that flux reference and available torque count on. Where rotor resistance or
/// inductances differ from the drive's parameters, a steady state needs more voltage than computed, and the
/// mean torque misses its reference against the rotation: less when motoring, more when regenerating. While
/// that mean error is beyond a tolerance, the usable share of the voltage's square falls, at a rate in
/// proportion; else it returns slowly. The tolerance is a share of the torque that an active vector adds in
/// one period,  p ψ u_dc T/(σL_s),  because sampling biases the mean in proportion to it. The mean leaves out
/// the first `settling_time` after a step of the torque reference or an interruption, and the flux on its
/// way. A reference that moves by the breakdown torque within 40 ms or faster counts as a step, unless it
/// follows a limit. Rates and times are chosen: faster than the thermal change of the machine, slower than
/// its transients. After D. Casadei, G. Serra, A. Stefani, A. Tani, L. Zarri, "DTC drives for wide speed
/// range applications using a robust flux-weakening algorithm", IEEE Trans. Ind. Electron. 54 (2007)
/// 2451–2461, who lower the flux by the same error.
template <class T = double>
class VoltageReserve {
 public:
  /// holds_mean_torque: of the controller, by which the tolerance is half the torque of an active vector or
  /// all of it; flux_reference [Wb], control period [ns].
  constexpr VoltageReserve(bool holds_mean_torque, const InductionMachineParameters<T>& m, T flux_reference,
                           std::int32_t period_ns) noexcept
      : tolerance_{(holds_mean_torque ? T(0.5) : T(1)) * T(m.pole_pairs) * flux_reference * T(period_ns) *
                   T(1e-9) / m.sigma_l_s()},
        rate_{T(700) / breakdown_torque(m, flux_reference)},
        fast_{breakdown_torque(m, flux_reference) / T(0.04)} {}

  /// One period of dt [s].
  constexpr void step(const TorqueTracking<T>& now, T dt) noexcept {
    const bool stepped = steps(now, dt);
    if (!now.makes_torque || now.interrupted || stepped) {
      settling_ = settling_time;
      mean_ = T(0);
    } else if (!now.slews) {
      settling_ = std::max(T(0), settling_ - dt);
    }
    const T excess = now.slews || settling_ > T(0) ? T(0) : mean_excess(now, dt);
    usable_ += (excess > T(0) ? -rate_ * excess : return_rate) * dt;
    usable_ = std::clamp(usable_, least_usable, T(1));
  }

  /// Takes the tolerance of another one for the same machine, flux reference and period.
  constexpr void take_parameters(const VoltageReserve& from) noexcept { tolerance_ = from.tolerance_; }

  /// Usable share of the square of the voltage, in (0, 1]. [-]
  [[nodiscard]] constexpr T usable() const noexcept { return usable_; }

 private:
  static constexpr T settling_time = T(5e-3);  // [s]
  static constexpr T mean_time = T(2e-3);      // [s]
  static constexpr T return_rate = T(0.05);    // [1/s]
  static constexpr T least_usable = T(0.4);

  constexpr bool steps(const TorqueTracking<T>& now, T dt) noexcept {
    const bool is_fast = std::abs(now.reference - reference_before_) > fast_ * dt;
    const bool follows_limit = now.limited && limited_before_;
    reference_before_ = now.reference;
    limited_before_ = now.limited;
    return is_fast && !follows_limit;
  }

  /// Mean error against the rotation beyond the tolerance. [N·m]
  constexpr T mean_excess(const TorqueTracking<T>& now, T dt) noexcept {
    const T error = now.reference - now.torque;
    mean_ += ((now.omega_m < T(0) ? -error : error) - mean_) * std::min(T(1), dt * (T(1) / mean_time));
    return mean_ - tolerance_ * now.u_dc * now.flux_share;
  }

  T tolerance_;  ///< by the link voltage, at the flux reference [N·m/V]
  T rate_;       ///< by the error above it [1/(N·m·s)]
  T fast_;       ///< rate of a reference that steps [N·m/s]
  T mean_{};     ///< of the error [N·m]
  T usable_{1};
  T settling_{settling_time};  ///< time until the mean begins [s]
  T reference_before_{};       ///< [N·m]
  bool limited_before_{false};
};

}  // namespace sextant
