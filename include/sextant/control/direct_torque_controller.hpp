#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/control/controller.hpp"
#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_comparator.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/control/magnetiser.hpp"
#include "sextant/control/sector_selector.hpp"
#include "sextant/control/switching_table.hpp"
#include "sextant/control/torque_comparator.hpp"

namespace sextant {

/// Conventional direct torque control (paper, 2.2): estimator → comparators → sector → switching table.
/// One switching state a period.
template <class T = double>
class DirectTorqueController final : public Controller<T> {
 public:
  static constexpr const char* name = "dtc";
  static constexpr const char* meaning = "direct torque control by a switching table";

  struct Parameters {
    InductionMachineParameters<T> machine{};  ///< the controller's parameters of the machine
    std::int32_t period_ns{25'000};           ///< control period [ns]
    T flux_reference{T(1.1)};                 ///< ψ_ref [Wb]
    int actuation_delay_periods{0};           ///< 1 when a pattern is applied one period late [-]
    typename TorqueComparator<T>::Parameters torque_comparator{};
    typename FluxComparator<T>::Parameters flux_comparator{};
    typename SectorSelector<T>::Parameters sector{};
    typename Magnetiser<T>::Parameters magnetiser{};

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (!(std::isfinite(flux_reference) && flux_reference > T(0))) {
        return "the flux reference must be above zero";
      }
      if (flux_comparator.band >= flux_reference) return "the flux band must be below the flux reference";
      if (actuation_delay_periods < 0 || actuation_delay_periods > 1) {
        return "the actuation delay must be 0 or 1 periods";
      }
      if (const char* problem = machine.validate()) return problem;
      if (const char* problem = torque_comparator.validate()) return problem;
      if (const char* problem = flux_comparator.validate()) return problem;
      if (const char* problem = sector.validate()) return problem;
      if (const char* problem = magnetiser.validate()) return problem;
      // Magnetising ends only if the current, ripple included, reaches ψ_ref / L_s.
      if (!(T(0.9) * magnetiser.current_limit * machine.l_s() > flux_reference)) {
        return "the magnetising current limit is too low for the flux reference";
      }
      // Below ψ_ref / L_s the flux would have to fall again before the current is low enough.
      if (!(T(0.9) * magnetiser.hand_over_current * machine.l_s() > flux_reference)) {
        return "the hand-over current is too low for the flux reference";
      }
      return nullptr;
    }
  };

  explicit DirectTorqueController(const Parameters& parameters) noexcept
      : parameters_{parameters},
        estimator_{parameters.machine},
        torque_comparator_{parameters.torque_comparator},
        flux_comparator_{parameters.flux_comparator},
        sector_{parameters.sector},
        magnetiser_{parameters.magnetiser} {}

  [[nodiscard]] GatePattern step(const Measurement<T>& measurement,
                                 ControlReference<T> reference) noexcept SEXTANT_NONBLOCKING override {
    estimator_.step(measurement);
    estimate_.psi_s = estimator_.psi_s();
    estimate_.psi_s_magnitude = magnitude(estimate_.psi_s);
    estimate_.torque = estimator_.torque();
    state_ = next_state(measurement, reference);
    estimate_.magnetised = magnetiser_.done();
    estimate_.sector = estimate_.psi_s_magnitude > T(0) ? sector_.sector() : std::uint8_t{0};
    return GatePattern{state_, parameters_.period_ns};
  }

  void reset() noexcept SEXTANT_NONBLOCKING override {
    estimator_.reset();
    estimate_ = {};
    sector_.reset();
    rest();
    state_ = gates_off;
  }

  /// Output of the torque comparator: +1 raise the torque, −1 lower it, 0 hold.
  [[nodiscard]] int torque_demand() const noexcept SEXTANT_NONBLOCKING { return torque_comparator_.output(); }
  /// Output of the flux comparator: true to raise the flux.
  [[nodiscard]] bool flux_demand() const noexcept SEXTANT_NONBLOCKING { return flux_comparator_.output(); }

 private:
  using Controller<T>::estimate_;

  [[nodiscard]] SwitchState next_state(const Measurement<T>& measurement,
                                       ControlReference<T> reference) noexcept {
    switch (reference.mode) {
      case ControlMode::torque:
        return torque_state(measurement, reference.torque);
      case ControlMode::magnetise:
        sector_.step(estimator_.psi_s());
        return magnetiser_.step(estimate_.psi_s_magnitude, parameters_.flux_reference,
                                magnitude(estimator_.i_s()));
      case ControlMode::off:
        break;
    }
    rest();
    return gates_off;
  }

  /// The paper's Figures 2, 5 and 6: estimate, comparators and sector, switching table.
  [[nodiscard]] SwitchState torque_state(const Measurement<T>& measurement, T torque_reference) noexcept {
    if (parameters_.actuation_delay_periods == 0) {
      return decide(estimate_.psi_s, estimate_.psi_s_magnitude, estimate_.torque, torque_reference);
    }
    const GatePattern in_flight{state_, parameters_.period_ns};
    const FluxAndCurrent<T> ahead = predict(estimator_, measurement.u_dc, measurement.omega_m, in_flight);
    const T torque = electromagnetic_torque(parameters_.machine.pole_pairs, ahead.psi_s, ahead.i_s);
    return decide(ahead.psi_s, magnitude(ahead.psi_s), torque, torque_reference);
  }

  [[nodiscard]] SwitchState decide(SpaceVector<T> psi_s, T psi_s_magnitude, T torque,
                                   T torque_reference) noexcept {
    const int torque_demand = torque_comparator_.step(torque_reference - torque);
    const bool raise_flux = flux_comparator_.step(parameters_.flux_reference - psi_s_magnitude);
    return select_state(sector_.step(psi_s), raise_flux, torque_demand, state_);
  }

  void rest() noexcept {
    torque_comparator_.reset();
    flux_comparator_.reset();
    magnetiser_.reset();
    sector_.step(estimator_.psi_s());
  }

  Parameters parameters_;
  FluxTorqueEstimator<T> estimator_;
  TorqueComparator<T> torque_comparator_;
  FluxComparator<T> flux_comparator_;
  SectorSelector<T> sector_;
  Magnetiser<T> magnetiser_;
  SwitchState state_{gates_off};
};

}  // namespace sextant
