#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/control/adaptive_observer.hpp"
#include "sextant/control/compensated_voltage_model.hpp"
#include "sextant/control/current_decay.hpp"
#include "sextant/control/current_model.hpp"
#include "sextant/control/flux_crossover.hpp"
#include "sextant/control/flux_estimator_kind.hpp"
#include "sextant/control/hybrid_flux_model.hpp"
#include "sextant/control/iron_loss_estimate.hpp"
#include "sextant/control/magnetising_identification.hpp"
#include "sextant/control/parameter_adaptation.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/core/iron_torque.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/core/winding_resistance.hpp"

namespace sextant {

/// Stator flux and torque (paper, 2.2.1) by one of several models while the gates are driven. While they are
/// off the current model continues the flux, so that a drive can be enabled again on a spinning machine that
/// still has rotor flux, also after a gap of many periods. Each model starts from the other's result.
/// While the machine is magnetised, the kinds that use its parameters identify them, and use them from then
/// on; the hybrid adapts them while torque is made. The other kinds keep those configured, as all do with
/// `adapts` false. What is not known of the voltage (`InverterModel::Parameters::voltage_error`) counts in
/// the hybrid, in identification and in adaptation.
///
/// Where the main flux is known to saturate all models have the linear machine with the currents of the
/// present flux (`SaturationCurve::machine_at`); what is identified and adapted is the machine at the flux of
/// the curve's L_m.
///
/// Where the iron loss is known (`IronLossEstimate`) it takes i_fe of the current that the current model has
/// beside, and its torque from the torque; both are those of the period before. While the gates are off it
/// takes nothing.
///
/// Where R_s varies with a known temperature of the winding (`WindingResistance`), the temperature scales R_s
/// in use, whatever has made it, and the configured R_s about which identification and adaptation have their
/// prior and their bounds: what these have found of R_s is kept as a factor.
template <class T = double>
class FluxTorqueEstimator {
 public:
  using Machine = InductionMachineParameters<T>;

  struct Parameters {
    Machine machine{};  ///< as configured
    FluxEstimatorKind kind{FluxEstimatorKind::voltage_model};
    bool adapts{true};                                 ///< R_s, R_r and L_m follow the machine
    typename InverterModel<T>::Parameters inverter{};  ///< what makes the voltage of the applied patterns
    T flux_reference{T(1.1)};                          ///< [Wb]
    SaturationParameters<T> saturation{};              ///< of the main flux
    WindingResistance<T> winding{};           ///< by which R_s follows the measurement's winding temperature
    T iron_loss_resistance{no_iron_loss<T>};  ///< R_fe per phase; infinite: none [Ω]
  };

  explicit FluxTorqueEstimator(const Parameters& parameters) noexcept
      : parameters_{parameters},
        machine_{parameters.machine},
        present_{machine_},
        saturation_{parameters.saturation, machine_.l_s()},
        most_flux_{SaturationShape<T>::most_flux * parameters.flux_reference},
        inverter_{parameters.inverter, machine_.sigma_l_s()},
        current_model_{machine_},
        compensated_{machine_.r_s / machine_.l_s()},
        hybrid_{machine_,
                flux_crossover(machine_, parameters.inverter.voltage_error, parameters.flux_reference)},
        observer_{machine_, parameters.kind == FluxEstimatorKind::sensorless_observer},
        identification_{machine_, parameters.inverter.voltage_error, parameters.flux_reference,
                        known_saturation()},
        adaptation_{machine_, parameters.inverter.voltage_error},
        torque_gain_{T(1.5) * T(machine_.pole_pairs)},
        iron_loss_{parameters.iron_loss_resistance, torque_gain_} {}

  /// Updates the estimate by the measurement at the end of a period and its applied pattern. `magnetising`:
  /// the pattern was to magnetise the machine without torque.
  void step(const Measurement<T>& measurement, bool magnetising = false) noexcept {
    const SpaceVector<T> i_s_before = i_s_;
    i_s_ = clarke(measurement.i_abc);
    if (parameters_.winding.varies() || saturation_.acts()) [[unlikely]]
      follow(measurement.winding_temperature);
    const ThreePhase<T> beyond = inverter_.step(measurement.applied, measurement.i_abc, measurement.u_dc);
    age(T(measurement.applied.duration_ns()) * T(1e-9));
    if (measurement.applied.is_driven()) {
      step_driven(measurement, clarke(beyond), i_s_before, magnetising && identifies());
    } else {
      if (!magnetising) magnetised_ = T(0);
      step_coasting(measurement, i_s_before);
    }
    omega_m_ = measurement.omega_m;
    if (iron_loss_.acts()) [[unlikely]]
      iron_loss_.step(current_model_, present_, psi_s_, i_s_, omega_m());
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_s() const noexcept { return psi_s_; }  ///< [Wb]
  [[nodiscard]] constexpr SpaceVector<T> i_s() const noexcept { return i_s_; }      ///< [A]
  [[nodiscard]] constexpr T torque() const noexcept {
    return torque_gain_ * cross(psi_s_, i_s_);  // [N·m]
  }
  /// What the iron loss takes of that. [N·m]
  [[nodiscard]] constexpr T iron_loss_torque() const noexcept { return iron_loss_.torque(); }
  /// Speed of the model: measured, or estimated where the kind does without a sensor. [rad/s]
  [[nodiscard]] constexpr T omega_m() const noexcept {
    return parameters_.kind == FluxEstimatorKind::sensorless_observer ? observer_.omega_m() : omega_m_;
  }
  /// While the machine is magnetised: it has been for as long as the gates had been off since magnetising
  /// last ended, or for the settling time of the identification. A period of which a part is off counts as
  /// off, as do missed periods in which the gate driver turns the gates off; the identification, which begins
  /// anew after them, may then have found nothing.
  [[nodiscard]] bool is_settled() const noexcept {
    return !identifies() || magnetised_ >= std::min(coasted_, identification_.settling_time());
  }

  [[nodiscard]] constexpr const CurrentModel<T>& current_model() const noexcept { return current_model_; }
  /// The inverter, as it was left at the last measurement.
  [[nodiscard]] constexpr const InverterModel<T>& inverter() const noexcept { return inverter_; }
  /// The machine's parameters in use, at the present flux.
  [[nodiscard]] constexpr const Machine& machine() const noexcept { return present_; }
  /// The same at another stator flux. [Wb]
  [[nodiscard]] Machine machine_at(T psi_s) const noexcept {
    return saturation_.machine_at(machine_, {std::min(most_flux_, psi_s), T(0)});
  }

  /// What is not known of them, as relative standard deviations: those of the prior until something is
  /// identified. [-]
  [[nodiscard]] constexpr const ParameterDeviations<T>& deviations() const noexcept { return deviations_; }

  /// Takes the iron loss of another one.
  constexpr void take_iron_loss(const FluxTorqueEstimator& from) noexcept {
    parameters_.iron_loss_resistance = from.parameters_.iron_loss_resistance;
    iron_loss_.take_parameters(from.iron_loss_);
  }

  /// Flux zero and parameters as configured, as after power-up.
  void reset() noexcept { *this = FluxTorqueEstimator{Parameters{parameters_}}; }

  /// The same with the gates off, but for the rotor flux: a machine keeps it for some τ_r.
  void restart() noexcept {
    const SpaceVector<T> psi_r = coasting_ ? current_model_.psi_r() : current_model_.psi_r_from(psi_s_, i_s_);
    const T omega_m = omega_m_;
    reset();
    current_model_.set(psi_r);
    psi_s_ = current_model_.psi_s(i_s_);
    omega_m_ = omega_m;
  }

 private:
  [[nodiscard]] constexpr bool identifies() const noexcept {
    const FluxEstimatorKind kind = parameters_.kind;
    return parameters_.adapts &&
           (kind == FluxEstimatorKind::hybrid || kind == FluxEstimatorKind::current_model ||
            kind == FluxEstimatorKind::observer);
  }

  /// beyond: ∫u_s dt beyond that of an ideal inverter. [V·s]
  void step_driven(const Measurement<T>& m, SpaceVector<T> beyond, SpaceVector<T> i_s_before,
                   bool identify) noexcept {
    if (coasting_) {
      set_flux(psi_s_, i_s_before);
      adaptation_.reset();
    }
    coasting_ = false;
    const T dt = T(m.applied.duration_ns()) * T(1e-9);
    if (!(dt > T(0))) return;
    const Period period{volt_seconds(m.applied, m.u_dc) + beyond, i_s_before, T(0.5) * (i_s_before + i_s_),
                        T(0.5) * (omega_m_ + m.omega_m), dt};
    if (identify) return step_magnetising(period);
    if (identifying_) adopt(i_s_before);
    step_model(period);
  }

  /// What a driven period brought.
  struct Period {
    SpaceVector<T> volt_seconds;  ///< ∫u_s dt [V·s]
    SpaceVector<T> i_s_before;    ///< at its beginning [A]
    SpaceVector<T> i_s_mean;      ///< [A]
    T omega_m;                    ///< mean [rad/s]
    T dt;                         ///< [s]
  };

  void step_model(const Period& p) noexcept {
    const SpaceVector<T> flux_change = p.volt_seconds - (present_.r_s * p.dt) * p.i_s_mean;
    switch (parameters_.kind) {
      case FluxEstimatorKind::compensated_voltage_model:
        compensated_.step(flux_change, p.dt);
        psi_s_ = compensated_.psi_s();
        break;
      case FluxEstimatorKind::current_model:
        current_model_.step(p.i_s_mean - iron_loss_.current(), p.omega_m, p.dt);
        psi_s_ = current_model_.psi_s(i_s_);
        break;
      case FluxEstimatorKind::observer:
      case FluxEstimatorKind::sensorless_observer:
        observer_.step(p.volt_seconds, i_s_, p.omega_m, p.dt);
        psi_s_ = observer_.psi_s(i_s_);
        break;
      case FluxEstimatorKind::voltage_model:
        psi_s_ += flux_change;
        break;
      case FluxEstimatorKind::hybrid:
        current_model_.step(p.i_s_mean - iron_loss_.current(), p.omega_m, p.dt);
        hybrid_.step(flux_change, current_model_, i_s_, p.omega_m, p.dt);
        psi_s_ = hybrid_.psi_s();
        if (parameters_.adapts && adaptation_.count(p.dt)) adapt();
        break;
    }
  }

  /// The parameters follow the machine, whose windings warm, as far as both models of the hybrid show it.
  void adapt() noexcept {
    use(adaptation_.update(machine_, {.excess = hybrid_.excess(),
                                      .rates = hybrid_.rates(),
                                      .i_s = i_s_,
                                      .psi_r = current_model_.psi_r(),
                                      .psi_s = psi_s_,
                                      .present = present_,
                                      .steepness = steepness()}));
    const SpaceVector<T> psi_r = current_model_.psi_r();
    current_model_.set(psi_r + product(adaptation_.correction().psi_r, psi_r));
    hybrid_.correct(adaptation_.correction().excess);
  }

  /// The parameters as configured, with R_s of the winding's temperature.
  [[nodiscard]] constexpr Machine warm() const noexcept {
    Machine machine = parameters_.machine;
    machine.r_s *= warmth_;
    return machine;
  }

  /// By how much σL_s of the present flux exceeds that at the flux of L_m, behind which identification looks.
  /// [H]
  [[nodiscard]] T more_leakage() const noexcept { return present_.sigma_l_s() - machine_.sigma_l_s(); }
  /// ψ_s − σL_s i_s of the latter, along a rotor flux [Wb], at a current [A]. [Wb]
  [[nodiscard]] T behind_leakage(SpaceVector<T> psi_r, SpaceVector<T> i_s) const noexcept {
    return present_.k_r() * magnitude(psi_r) + more_leakage() * dot(direction(psi_r), i_s);
  }

  // The next three are apart, so that the step of a drive that makes torque stays small.

  /// R_s is that of the winding's temperature [°C], the machine that of the present flux.
  [[gnu::noinline]] void follow(const std::optional<T>& temperature) noexcept {
    const bool is_new = parameters_.winding.varies() && temperature && *temperature != temperature_;
    if (is_new) {
      temperature_ = *temperature;
      const T warmth = parameters_.winding.ratio(*temperature);
      machine_.r_s *= warmth / warmth_;
      warmth_ = warmth;
      adaptation_.set_configured(warm());
    }
    if (is_new || saturation_.acts()) follow_flux();
  }

  /// The current is in the direction of the rotor flux: only the magnitude of the flux is in question.
  [[gnu::noinline]] void step_magnetising(const Period& p) noexcept {
    if (!identifying_) current_model_.set(current_model_.psi_r_from(psi_s_, p.i_s_before));
    const T omega_r = T(machine_.pole_pairs) * p.omega_m;
    if (!identifying_) {
      if (parameters_.winding.varies()) {
        identification_ = {warm(), parameters_.inverter.voltage_error, parameters_.flux_reference,
                           known_saturation()};
      }
      identification_.begin(behind_leakage(current_model_.psi_r(), p.i_s_before), omega_r);
    }
    magnetised_ += p.dt;
    const SpaceVector<T> psi_r_before = current_model_.psi_r();
    const SpaceVector<T> i_s_mean = p.i_s_mean - iron_loss_.current();
    current_model_.step(i_s_mean, p.omega_m, p.dt);
    identifying_ = true;
    if (adaptation_.count(p.dt)) {
      adaptation_.magnetise(present_, i_s_, current_model_.psi_r(), steepness());
    }
    const SpaceVector<T> middle = direction(psi_r_before + current_model_.psi_r());
    const SpaceVector<T> voltage =
        (T(1) / p.dt) * (p.volt_seconds - machine_.sigma_l_s() * (i_s_ - p.i_s_before)) -
        present_.r_s * iron_loss_.current();
    identification_.step({dot(middle, voltage), cross(middle, voltage)},
                         {dot(middle, i_s_mean), cross(middle, i_s_mean)},
                         behind_leakage(current_model_.psi_r(), i_s_), omega_r, p.dt);
    current_model_.set(product(identification_.turn(p.dt), current_model_.psi_r()));
    psi_s_ = identification_.flux() * direction(current_model_.psi_r()) + machine_.sigma_l_s() * i_s_;
  }

  /// Magnetising has ended, at this current [A]: its flux and what it identified are where the models start.
  [[gnu::noinline]] void adopt(SpaceVector<T> i_s_before) noexcept {
    identifying_ = false;
    coasted_ = T(0);
    magnetised_ = T(0);
    const SpaceVector<T> along = product(identification_.direction(), direction(current_model_.psi_r()));
    const Machine found = identification_.finish(machine_);
    if (identification_.has_found()) adaptation_.set(identification_.covariance());
    use(found);
    const T k_r_psi_r = identification_.flux() - more_leakage() * dot(along, i_s_before);
    current_model_.set((k_r_psi_r / present_.k_r()) * along);
    set_flux(current_model_.psi_s(i_s_before), i_s_before);
    if (identification_.has_found()) {
      adaptation_.begin_identified();
    } else {
      adaptation_.reset();
    }
  }

  void step_coasting(const Measurement<T>& measurement, SpaceVector<T> i_s_before) noexcept {
    if (!coasting_) current_model_.set(current_model_.psi_r_from(psi_s_, i_s_before));
    coasting_ = true;
    identifying_ = false;
    const T dt = T(measurement.applied.duration_ns()) * T(1e-9);
    coasted_ += dt;
    const T omega_m = T(0.5) * (omega_m_ + measurement.omega_m);
    const T decay = std::min(dt, driven_time<T>(measurement.applied) +
                                     decay_time(machine_.sigma_l_s(), measurement.u_dc, i_s_before, dt));
    if (decay > T(0)) current_model_.step(T(0.5) * (i_s_before + i_s_), omega_m, decay);
    if (decay < dt) current_model_.step(i_s_, omega_m, dt - decay);
    psi_s_ = current_model_.psi_s(i_s_);
  }

  /// The flux from which the models go on [Wb], and the current of the same instant [A].
  void set_flux(SpaceVector<T> psi_s, SpaceVector<T> i_s) noexcept {
    psi_s_ = psi_s;
    compensated_.set(psi_s, T(machine_.pole_pairs) * omega_m_);
    hybrid_.set(psi_s);
    observer_.set(current_model_.psi_r_from(psi_s, i_s), i_s, omega_m_);
  }

  /// The machine may warm or cool meanwhile.
  void age(T dt) noexcept {
    unaged_ += dt;
    if (unaged_ < aging_time) return;
    adaptation_.age(unaged_);
    deviations_ = adaptation_.covariance().deviations();
    unaged_ = T(0);
  }

  void use(const Machine& machine) noexcept {
    machine_ = machine;
    deviations_ = adaptation_.covariance().deviations();
    follow_flux();
  }

  /// The models have the machine of the present flux.
  void follow_flux() noexcept {
    present_ = machine_at(magnitude(psi_s_));
    current_model_.set_machine(present_);
    observer_.set_machine(present_);
  }
  /// Of the curve at the present flux. [-]
  [[nodiscard]] T steepness() const noexcept {
    return saturation_.steepness({std::min(most_flux_, magnitude(psi_s_)), T(0)});
  }
  /// What identification knows of the iron before it begins.
  [[nodiscard]] typename MagnetisingIdentification<T>::Saturation known_saturation() const noexcept {
    return SaturationShape<T>::of(parameters_.saturation, parameters_.flux_reference);
  }

  static constexpr T aging_time = T(0.1);  ///< in which the windings keep their temperature [s]

  Parameters parameters_;
  Machine machine_;  ///< in use, at the flux of its L_m
  Machine present_;  ///< the same at the present flux
  SaturationCurve<T> saturation_;
  T most_flux_;  ///< up to which the curve counts: a wrong flux is not to make a machine that is none [Wb]
  InverterModel<T> inverter_;
  CurrentModel<T> current_model_;
  CompensatedVoltageModel<T> compensated_;
  HybridFluxModel<T> hybrid_;
  AdaptiveObserver<T> observer_;
  MagnetisingIdentification<T> identification_;
  ParameterAdaptation<T> adaptation_;
  ParameterDeviations<T> deviations_{ParameterCovariance<T>{}.deviations()};
  T unaged_{};                                          ///< time since the last aging [s]
  T warmth_{1};                                         ///< R_s by temperature, of that configured [-]
  T temperature_{std::numeric_limits<T>::quiet_NaN()};  ///< of the winding, to which that belongs [°C]
  T torque_gain_;                                       ///< 3/2 p [-]
  IronLossEstimate<T> iron_loss_;
  SpaceVector<T> psi_s_{};
  SpaceVector<T> i_s_{};  ///< at the last measurement [A]
  T omega_m_{};           ///< at the last measurement [rad/s]
  T coasted_{T(1e3)};     ///< with gates off since magnetising last ended; long at power-up [s]
  T magnetised_{};        ///< time of driven periods in this magnetising [s]
  bool coasting_{true};
  bool identifying_{false};
};

}  // namespace sextant
