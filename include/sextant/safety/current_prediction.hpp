#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// By how much an interval ought to have changed the phase currents, v − e, in its parts.
template <class T = double>
struct PredictedChange {
  ThreePhase<T> v{};  ///< by the applied voltage [A]
  ThreePhase<T> e{};  ///< against it, by the voltage of the rotor flux and the drop at R_s [A]
  T uncertainty{};    ///< of v − e, by parameters and inverter, in one phase [A]
  T by_sign{};        ///< of v, what hangs on the sign of the phase's own current [A]
  T error_turn{};     ///< by how much an error of e may differ from that of the interval before [A]
  T turn{};           ///< of the rotor flux [rad]
  T rotor_turn{};     ///< of the rotor, electrical [rad]
};

/// Rotor flux at a measurement, and how wrong it may be.
template <class T = double>
struct PredictedFlux {
  SpaceVector<T> psi_r{};  ///< [Wb]
  T error{};               ///< of it, at most [Wb]
  T rotor_turn{};          ///< of the rotor since the measurement before, electrical [rad]
};

/// Predicts the change of the phase currents from measurement to measurement by the transient model of the
/// machine, integrated over the time between them, a control period or more:
///   σL_s Δi_k = ∫u_k dt − R_s ∫i_k dt − k_r Δψ_r,k,   Δi_k = v_k − e_k
/// Source: P. Vas, Sensorless Vector and Direct Torque Control, 1998. The rotor flux is that of the torque
/// monitor (`MonitoredFlux`), from currents and speed. Exact but for the mean current, which is that of both
/// measurements.
///
/// e may be wrong by `emf_uncertainty` of it, or by k_r Δψ |p ω_m| dt/σL_s where the rotor flux may be wrong
/// by more than itself, Δψ: while the flux of the monitor decays faster than the machine's own, as on the way
/// into weakened flux, the true e is a multiple of the predicted one, which may vanish. This error turns with
/// the rotor.
template <class T = double>
class CurrentPrediction {
 public:
  /// Taken to be wrong at least, of e: by errors of R_s, R_r, L_m, the speed, and by saturation. A true e of
  /// twice the model's is one by a model of L_m 0.7 and R_r 0.5 times theirs. [-]
  static constexpr T emf_uncertainty = T(1);
  /// Taken to be wrong at most, of an active vector's 2/3 u_dc: by dead time and drops, beside what is stated
  /// of them. [-]
  static constexpr T voltage_uncertainty = T(0.02);

  /// inverter: of its stated voltage error two are allowed for; what dead time and threshold take of a
  /// phase's voltage, two thirds of what they take of its leg's, has the sign of its current, which a reading
  /// near zero does not show. period_ns: control period. [ns]
  CurrentPrediction(const InductionMachineParameters<T>& machine,
                    const typename InverterModel<T>::Parameters& inverter, std::int32_t period_ns) noexcept
      : inverse_inductance_{T(1) / machine.sigma_l_s()},
        half_resistance_{T(0.5) * machine.r_s * inverse_inductance_},
        flux_gain_{machine.k_r() * inverse_inductance_},
        voltage_error_{voltage_uncertainty * T(2) / T(3) * inverse_inductance_},
        stated_error_{T(2) * inverter.voltage_error * inverse_inductance_},
        dead_share_{T(2) / T(3) * inverse_inductance_ * T(inverter.dead_time_ns) / T(period_ns)},
        threshold_{T(2) / T(3) * inverse_inductance_ * inverter.threshold_voltage} {}

  /// The end of an interval of dt [s] in which every leg was driven: currents [A], rotor flux, ∫u_x dt over
  /// it [V·s] and link voltage [V].
  [[nodiscard]] PredictedChange<T> step(const ThreePhase<T>& i, const PredictedFlux<T>& rotor,
                                        const ThreePhase<T>& volt_seconds, T u_dc, T dt) noexcept {
    const SpaceVector<T> psi_r = rotor.psi_r;
    const T resistive = half_resistance_ * dt;
    const ThreePhase<T> flux = inverse_clarke(psi_r - psi_r_);
    PredictedChange<T> out{
        .v = {inverse_inductance_ * volt_seconds.a, inverse_inductance_ * volt_seconds.b,
              inverse_inductance_ * volt_seconds.c},
        .e = {resistive * (i_.a + i.a) + flux_gain_ * flux.a, resistive * (i_.b + i.b) + flux_gain_ * flux.b,
              resistive * (i_.c + i.c) + flux_gain_ * flux.c}};
    out.rotor_turn = rotor.rotor_turn;
    const T turn = std::abs(rotor.rotor_turn);
    const T by_flux = flux_gain_ * rotor.error * turn;
    out.uncertainty = std::max(emf_uncertainty * magnitude(clarke(out.e)), by_flux) +
                      (voltage_error_ * u_dc + stated_error_) * dt;
    out.by_sign = (dead_share_ * std::max(T(0), u_dc) + threshold_) * dt;
    out.error_turn = by_flux * turn;
    const T square = std::max(dot(psi_r, psi_r), dot(psi_r_, psi_r_));
    out.turn = square > T(0) ? cross(psi_r_, psi_r) / square : T(0);
    restart(i, psi_r);
    return out;
  }

  /// An interval that does not count: currents [A] and rotor flux [Wb] at its end.
  constexpr void restart(const ThreePhase<T>& i, SpaceVector<T> psi_r) noexcept {
    i_ = i;
    psi_r_ = psi_r;
  }

 private:
  T inverse_inductance_;    ///< 1/σL_s [1/H]
  T half_resistance_;       ///< R_s/(2 σL_s) [1/s]
  T flux_gain_;             ///< k_r/σL_s [A/Wb]
  T voltage_error_;         ///< of v by u_dc, a second [A/(V·s)]
  T stated_error_;          ///< the same, stated [A/s]
  T dead_share_;            ///< of v, what dead times take by u_dc, a second [A/(V·s)]
  T threshold_;             ///< the same, the threshold voltage [A/s]
  ThreePhase<T> i_{};       ///< at the last measurement [A]
  SpaceVector<T> psi_r_{};  ///< at the last measurement [Wb]
};

}  // namespace sextant
