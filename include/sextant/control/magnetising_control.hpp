#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/control/magnetiser.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Leads the current, within one period, to the reference of the `Magnetiser` in the direction of the rotor
/// flux; along phase a where there is none.
template <class T = double>
class MagnetisingControl {
 public:
  using Parameters = typename Magnetiser<T>::Parameters;

  /// period: the control period. [s]
  constexpr MagnetisingControl(const Parameters& parameters, T period) noexcept
      : magnetiser_{parameters}, period_{period} {}

  /// For a method that takes one of few vectors a period: the quantum of the share of it for which an active
  /// one acts, so that it moves the current by no more than the limit has above the current that holds the
  /// flux psi_ref [Wb]:
  ///   (I − ψ_ref/L_s)/((2/3) u_dc t_period/σL_s), at most 1
  /// With a larger one the nearest to any voltage would overshoot the limit, or be a zero vector, and no flux
  /// would arise; multiples of it feed the EMF of a shaft that turns. u_dc [V].
  [[nodiscard]] constexpr T vector_quantum(const InductionMachineParameters<T>& machine, T psi_ref,
                                           T u_dc) const noexcept {
    const T largest_step = T(2.0 / 3.0) * u_dc * period_ / machine.sigma_l_s();
    const T room = magnetiser_.current_limit() - psi_ref / machine.l_s();
    return room < largest_step ? room / largest_step : T(1);
  }

  /// The stator voltage of the coming period, in which rotor flux and EMF turn by ω_r t_period: the current
  /// is to end in the direction that the flux has then, and the mean of the EMF is
  ///   e^{jω_r t/2} sin(ω_r t/2)/(ω_r t/2) of that at the beginning.
  /// Taken as constant it would leave an error of the current of some (ω_r t)²/2 k_r ψ_r/σL_s. [V]
  /// x: flux and current at its beginning; psi_s: magnitude of the estimated flux now, and its reference
  /// [Wb]; u_most: the longest voltage in every direction [V]; omega_m [rad/s].
  [[nodiscard]] SpaceVector<T> step(const FluxTorqueEstimator<T>& estimator, const FluxAndCurrent<T>& x,
                                    T psi_s, T psi_ref, T u_most, T omega_m) noexcept {
    const InductionMachineParameters<T>& machine = estimator.machine();
    const CurrentModel<T>& model = estimator.current_model();
    const T per_volt = period_ / machine.sigma_l_s();  // change of the current in a period [A/V]
    const SpaceVector<T> psi_r = model.psi_r_from(x.psi_s, x.i_s);
    const T omega_r = T(machine.pole_pairs) * omega_m;
    // ω_r (k_r ψ_r + σL_s i_s) within it.
    const T fed_flux = u_most / std::max(std::abs(omega_r), T(1));
    const T fed_current = (fed_flux - machine.k_r() * magnitude(psi_r)) / machine.sigma_l_s();
    const T holding_current = psi_ref / estimator.machine_at(psi_ref).l_s();
    const T current = magnetiser_.step(psi_s, psi_ref, holding_current, magnitude(estimator.i_s()),
                                       fed_current, machine.sigma_l_s(), estimator.is_settled());
    const T half = T(0.5) * omega_r * period_;
    const SpaceVector<T> half_turn = polar(T(1), half);
    const T chord = half == T(0) ? T(1) : std::sin(half) / half;
    const SpaceVector<T> wanted = current * product(half_turn, product(half_turn, direction(psi_r)));
    const SpaceVector<T> emf =
        (chord * machine.k_r()) * product(half_turn, model.derivative(psi_r, x.i_s, omega_m));
    return (T(1) / per_volt) * (wanted - x.i_s) + machine.r_s * x.i_s + emf;
  }

  /// The flux is ready for torque.
  [[nodiscard]] constexpr bool done() const noexcept { return magnetiser_.done(); }
  constexpr void reset() noexcept { magnetiser_.reset(); }

 private:
  Magnetiser<T> magnetiser_;
  T period_;  ///< [s]
};

}  // namespace sextant
