#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/drive/steady_state.hpp"

namespace sextant {

/// Adapts the voltage that flux reference and available torque count on. Where rotor resistance or
/// inductances differ from the drive's parameters, a steady state needs more voltage than computed, and the
/// mean torque misses its reference against the rotation: less when motoring, more when regenerating. While
/// that mean error is beyond a tolerance, the usable share of the voltage's square falls, at a rate in
/// proportion; else it returns slowly. The tolerance is a share of the torque that an active vector adds in
/// one period,  p ψ u_dc T/(σL_s),  because sampling biases the mean in proportion to it. Steps of torque and
/// flux take some milliseconds at the voltage limit, after which the mean begins. After D. Casadei, G. Serra,
/// A. Stefani, A. Tani, L. Zarri, "DTC drives for wide speed range applications using a robust flux-weakening
/// algorithm", IEEE Trans. Ind. Electron. 54 (2007) 2451–2461, who lower the flux by the same error.
template <class T = double>
class VoltageReserve {
 public:
  struct Parameters {
    T tolerance{
        T(0.5)};  ///< by the torque of an active vector; 1 suits a mean torque that is not trimmed [-]

    [[nodiscard]] const char* validate() const noexcept {
      const bool good = std::isfinite(tolerance) && tolerance > T(0);
      return good ? nullptr : "the tolerance of the mean torque must be above zero";
    }
  };

  /// flux_reference [Wb], control period [ns].
  constexpr VoltageReserve(const Parameters& parameters, const InductionMachineParameters<T>& m,
                           T flux_reference, std::int32_t period_ns) noexcept
      : tolerance_{parameters.tolerance * T(m.pole_pairs) * flux_reference * T(period_ns) * T(1e-9) /
                   m.sigma_l_s()},
        rate_{T(700) / breakdown_torque(m, flux_reference)} {}

  /// One period of dt [s]: the torque error against the rotation, (reference − estimate)·sign(ω_m) [N·m],
  /// the link voltage [V], the share of the flux reference, and whether torque is made at the voltage limit
  /// and the references do not step.
  constexpr void step(T error, T u_dc, T flux_share, bool steady, T dt) noexcept {
    if (!steady && usable_ == T(1)) {
      settling_ = settling_time;
      return;
    }
    settling_ = steady ? std::max(T(0), settling_ - dt) : settling_time;
    mean_ = settling_ > T(0) ? T(0) : mean_ + (error - mean_) * std::min(T(1), dt * (T(1) / mean_time));
    const T excess = mean_ - tolerance_ * u_dc * flux_share;
    usable_ += (excess > T(0) ? -rate_ * excess : return_rate) * dt;
    usable_ = std::clamp(usable_, least_usable, T(1));
  }

  /// Usable share of the square of the voltage, in (0, 1]. [-]
  [[nodiscard]] constexpr T usable() const noexcept { return usable_; }

 private:
  static constexpr T settling_time = T(5e-3);  // [s]
  static constexpr T mean_time = T(2e-3);      // [s]
  static constexpr T return_rate = T(0.05);    // [1/s]
  static constexpr T least_usable = T(0.4);

  T tolerance_;  ///< by the link voltage, at the flux reference [N·m/V]
  T rate_;       ///< by the error above it [1/(N·m·s)]
  T mean_{};     ///< of the error [N·m]
  T usable_{1};
  T settling_{settling_time};  ///< time until the mean begins [s]
};

}  // namespace sextant
