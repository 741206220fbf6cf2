#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/control/controller.hpp"
#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_comparator.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/control/magnetising_control.hpp"
#include "sextant/control/sector_selector.hpp"
#include "sextant/control/switching_table.hpp"
#include "sextant/control/torque_comparator.hpp"
#include "sextant/control/torque_trim.hpp"

namespace sextant {

/// Conventional direct torque control (paper, 2.2): estimator → comparators → sector → switching table.
/// One switching state a period. Two additions, which `Parameters` can turn off: the flux has priority over
/// a torque that holds, and a trim of the torque reference takes the offset of the mean torque away.
template <class T = double>
class DirectTorqueController final : public Controller<T> {
 public:
  static constexpr const char* name = "dtc";
  static constexpr const char* meaning = "direct torque control by a switching table";

  struct Parameters {
    InductionMachineParameters<T> machine{};  ///< the controller's parameters of the machine
    std::int32_t period_ns{25'000};           ///< control period [ns]
    T flux_reference{T(1.1)};                 ///< ψ_ref at a flux share of 1 [Wb]
    FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
    int actuation_delay_periods{0};  ///< 1 when a pattern is applied one period late [-]
    typename TorqueComparator<T>::Parameters torque_comparator{};
    typename FluxComparator<T>::Parameters flux_comparator{};
    typename SectorSelector<T>::Parameters sector{};
    typename Magnetiser<T>::Parameters magnetiser{};
    /// In place of zero vectors the radial vector, while the flux is below its band and the current along
    /// it within the limit of magnetising [-]
    bool flux_priority{true};
    typename TorqueTrim<T>::Parameters torque_trim{};

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
      if (const char* problem = magnetiser.validate(machine, flux_reference)) return problem;
      if (const char* problem = torque_trim.validate()) return problem;
      return nullptr;
    }
  };

  explicit DirectTorqueController(const Parameters& parameters) noexcept
      : parameters_{parameters},
        estimator_{parameters.machine, parameters.flux_estimator},
        torque_comparator_{parameters.torque_comparator},
        flux_comparator_{parameters.flux_comparator},
        sector_{parameters.sector},
        magnetising_{parameters.magnetiser, period_of(parameters)},
        torque_trim_{parameters.torque_trim, parameters.machine, period_of(parameters)} {}

  [[nodiscard]] GatePattern step(const Measurement<T>& measurement,
                                 ControlReference<T> reference) noexcept SEXTANT_NONBLOCKING override {
    estimator_.step(measurement, mode_ == ControlMode::magnetise);
    mode_ = reference.mode;
    estimate_.psi_s = estimator_.psi_s();
    estimate_.psi_s_magnitude = magnitude(estimate_.psi_s);
    estimate_.torque = estimator_.torque();
    state_ = next_state(measurement, reference);
    estimate_.magnetised = magnetising_.done();
    estimate_.sector = estimate_.psi_s_magnitude > T(0) ? sector_.sector() : std::uint8_t{0};
    return GatePattern{state_, parameters_.period_ns};
  }

  void reset() noexcept SEXTANT_NONBLOCKING override {
    estimator_.reset();
    estimate_ = {};
    sector_.reset();
    rest();
    state_ = gates_off;
    mode_ = ControlMode::off;
  }

  /// Output of the torque comparator: +1 raise the torque, −1 lower it, 0 hold.
  [[nodiscard]] int torque_demand() const noexcept SEXTANT_NONBLOCKING { return torque_comparator_.output(); }
  /// Output of the flux comparator: true to raise the flux.
  [[nodiscard]] bool flux_demand() const noexcept SEXTANT_NONBLOCKING { return flux_comparator_.output(); }

 private:
  using Controller<T>::estimate_;

  [[nodiscard]] static constexpr T period_of(const Parameters& p) noexcept {
    return T(p.period_ns) * T(1e-9);  // [s]
  }

  [[nodiscard]] SwitchState next_state(const Measurement<T>& measurement,
                                       ControlReference<T> reference) noexcept {
    switch (reference.mode) {
      case ControlMode::torque:
        return torque_state(measurement, reference);
      case ControlMode::magnetise:
        sector_.step(estimator_.psi_s());
        return magnetising_state(measurement, flux_reference(reference));
      case ControlMode::off:
        break;
    }
    rest();
    return gates_off;
  }

  /// The paper's Figures 2, 5 and 6: estimate, comparators and sector, switching table.
  [[nodiscard]] SwitchState torque_state(const Measurement<T>& measurement,
                                         const ControlReference<T>& reference) noexcept {
    const T psi_ref = flux_reference(reference);
    const T torque_ref = torque_trim_.step(reference.torque, estimate_.torque, psi_ref, measurement.u_dc);
    if (parameters_.actuation_delay_periods == 0) {
      const FluxAndCurrent<T> now{estimate_.psi_s, estimator_.i_s()};
      return decide(now, estimate_.psi_s_magnitude, torque_ref - estimate_.torque, psi_ref);
    }
    const FluxAndCurrent<T> x = ahead(measurement);
    const T torque = electromagnetic_torque(parameters_.machine.pole_pairs, x.psi_s, x.i_s);
    return decide(x, magnitude(x.psi_s), torque_ref - torque, psi_ref);
  }

  /// Flux and current when the pattern that is decided now begins.
  [[nodiscard]] FluxAndCurrent<T> ahead(const Measurement<T>& measurement) const noexcept {
    if (parameters_.actuation_delay_periods == 0) return {estimator_.psi_s(), estimator_.i_s()};
    if (!is_driven(state_)) return {estimator_.psi_s(), estimator_.i_s()};
    return predict(estimator_, stator_voltage(state_, measurement.u_dc), period_of(parameters_));
  }

  [[nodiscard]] SwitchState decide(const FluxAndCurrent<T>& x, T psi_s, T torque_error, T psi_ref) noexcept {
    const int torque_demand = torque_comparator_.step(torque_error);
    const T flux_error = psi_ref - psi_s;
    const bool raise_flux = flux_comparator_.step(flux_error);
    return select_state(sector_.step(x.psi_s), raise_flux, torque_demand, state_,
                        needs_flux(x, psi_s, flux_error));
  }

  /// The condition of flux priority; i_s · ψ_s/|ψ_s| is the current along the flux.
  [[nodiscard]] bool needs_flux(const FluxAndCurrent<T>& x, T psi_s, T flux_error) const noexcept {
    return parameters_.flux_priority && flux_error > parameters_.flux_comparator.band &&
           dot(x.psi_s, x.i_s) <= parameters_.magnetiser.current_limit * psi_s;
  }

  [[nodiscard]] SwitchState magnetising_state(const Measurement<T>& measurement, T flux_reference) noexcept {
    const SpaceVector<T> u = magnetising_.step(estimator_, ahead(measurement), estimate_.psi_s_magnitude,
                                               flux_reference, measurement.u_dc, measurement.omega_m, T(0.5));
    const SwitchState state = nearest_state(u, measurement.u_dc);
    return state == gates_off ? nearest_zero_state(state_) : state;
  }

  [[nodiscard]] T flux_reference(const ControlReference<T>& reference) const noexcept {
    return reference.flux_share * parameters_.flux_reference;  // [Wb]
  }

  void rest() noexcept {
    torque_comparator_.reset();
    flux_comparator_.reset();
    magnetising_.reset();
    torque_trim_.reset();
    sector_.step(estimator_.psi_s());
  }

  Parameters parameters_;
  FluxTorqueEstimator<T> estimator_;
  TorqueComparator<T> torque_comparator_;
  FluxComparator<T> flux_comparator_;
  SectorSelector<T> sector_;
  MagnetisingControl<T> magnetising_;
  TorqueTrim<T> torque_trim_;
  SwitchState state_{gates_off};
  ControlMode mode_{ControlMode::off};  ///< of the last step
};

}  // namespace sextant
