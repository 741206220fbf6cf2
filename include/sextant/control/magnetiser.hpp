#pragma once

#include <cmath>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Builds up flux at standstill with direct current along phase a: V1 until the current reaches its limit,
/// a zero vector until it has fallen by a tenth of it. Done when the flux has reached its reference and the
/// current has fallen to the hand-over level, so that torque control starts without a surge.
template <class T = double>
class Magnetiser {
 public:
  struct Parameters {
    T current_limit{T(40)};      ///< peak of the magnetising current [A]
    T hand_over_current{T(30)};  ///< largest |i_s| at which torque control may start [A]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(current_limit) && current_limit > T(0))) {
        return "the magnetising current limit must be above zero";
      }
      if (!(std::isfinite(hand_over_current) && hand_over_current > T(0))) {
        return "the hand-over current must be above zero";
      }
      return nullptr;
    }
  };

  constexpr explicit Magnetiser(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// One period with |ψ_s| and its reference [Wb] and |i_s| [A]; returns the coming switching state.
  constexpr SwitchState step(T psi_s, T psi_ref, T current) noexcept {
    if (current >= parameters_.current_limit) driving_ = false;
    if (current <= T(0.9) * parameters_.current_limit) driving_ = true;
    if (psi_s >= psi_ref) reached_ = true;
    done_ = reached_ && current <= parameters_.hand_over_current;
    return driving_ && !reached_ ? switch_states[1] : switch_states[0];
  }

  [[nodiscard]] constexpr bool done() const noexcept { return done_; }

  constexpr void reset() noexcept {
    driving_ = true;
    reached_ = false;
    done_ = false;
  }

 private:
  Parameters parameters_;
  bool driving_{true};
  bool reached_{false};
  bool done_{false};
};

}  // namespace sextant
