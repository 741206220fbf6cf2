#pragma once

#include <algorithm>

#include "sextant/control/current_model.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/iron_torque.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// What a known iron loss takes, by the estimated fluxes: of the current of the rotor flux
/// i_fe = (1/R_fe) k_r dψ_r/dt, and `iron_torque`. With f that dψ_r/dt would be by all of i_s,
///   dψ_r/dt = f(i_s − i_fe) = f/(1 + k_r² R_r/R_fe)
/// The rotor's flux turns without the ripple of the stator's. While it is small beside the stator's it has no
/// speed of its own.
template <class T = double>
class IronLossEstimate {
 public:
  /// resistance: R_fe per phase, infinite: none [Ω]; torque_gain: 3/2 p [-].
  constexpr IronLossEstimate(T resistance, T torque_gain) noexcept
      : conductance_{T(1) / resistance}, torque_gain_{torque_gain} {}

  /// The iron loss is known.
  [[nodiscard]] constexpr bool acts() const noexcept { return conductance_ > T(0); }

  /// The end of a period: model and machine at the present flux, ψ_s [Wb], i_s [A], speed [rad/s]. Apart, so
  /// that the step of a drive without a known iron loss stays small.
  [[gnu::noinline]] void step(const CurrentModel<T>& model, const InductionMachineParameters<T>& machine,
                              SpaceVector<T> psi_s, SpaceVector<T> i_s, T omega_m) noexcept {
    const SpaceVector<T> psi_r = model.psi_r_from(psi_s, i_s);
    const T k_r = machine.k_r();
    const SpaceVector<T> rate =
        (T(1) / (T(1) + conductance_ * k_r * k_r * machine.r_r)) * model.derivative(psi_r, i_s, omega_m);
    const T stator_squared = dot(psi_s, psi_s);
    const T square = std::max(dot(psi_r, psi_r), T(0.25) * stator_squared);
    current_ = (conductance_ * k_r) * rate;
    torque_ = square > T(0)
                  ? iron_torque(torque_gain_, conductance_, cross(psi_r, rate) / square, stator_squared)
                  : T(0);
  }

  [[nodiscard]] constexpr SpaceVector<T> current() const noexcept { return current_; }  ///< i_fe [A]
  [[nodiscard]] constexpr T torque() const noexcept { return torque_; }                 ///< [N·m]

  /// Takes the resistance of another one; without a loss nothing is taken at once.
  constexpr void take_parameters(const IronLossEstimate& from) noexcept {
    conductance_ = from.conductance_;
    if (acts()) return;
    current_ = {};
    torque_ = T(0);
  }

 private:
  T conductance_;             ///< 1/R_fe [1/Ω]
  T torque_gain_;             ///< 3/2 p [-]
  SpaceVector<T> current_{};  ///< [A]
  T torque_{};                ///< [N·m]
};

}  // namespace sextant
