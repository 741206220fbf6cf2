#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// Limits the rate of the flux reference. The rotor flux follows the stator flux with the time constant
/// σ τ_r; the difference is carried by the current along the flux, which takes (dψ/dt) τ_r k_r²/L_s more
/// while the flux rises. Within ten of these time constants for the whole reference that is a tenth of the
/// current with which the whole flux would arise at once. Falling flux relieves current and voltage, and may
/// fall five times as fast, so that it makes room for a torque step. What the link cannot hold it leaves at
/// once.
template <class T = double>
class FluxSlew {
 public:
  constexpr explicit FluxSlew(const InductionMachineParameters<T>& m) noexcept
      : rise_{m.l_s() / (T(10) * m.sigma_l_s() * m.tau_r())}, fall_{T(5) * rise_} {}

  /// One period of dt [s]: the share of the flux reference on its way to `target`, at most `held`. [-]
  constexpr T step(T target, T held, T dt) noexcept {
    share_ = std::min(held, std::clamp(target, share_ - fall_ * dt, share_ + rise_ * dt));
    slewing_ = std::abs(target - share_) > T(0.02);
    return share_;
  }

  /// Takes over the share at once, while no flux follows it.
  constexpr T reset(T share) noexcept {
    slewing_ = false;
    return share_ = share;
  }

  /// The share in the last period. [-]
  [[nodiscard]] constexpr T share() const noexcept { return share_; }

  /// The share is on its way to a target that is further than 2 % of the flux reference off.
  [[nodiscard]] constexpr bool is_slewing() const noexcept { return slewing_; }

 private:
  T rise_;      ///< [1/s]
  T fall_;      ///< [1/s]
  T share_{1};  ///< [-]
  bool slewing_{false};
};

}  // namespace sextant
