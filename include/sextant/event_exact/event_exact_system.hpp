#pragma once

#include "sextant/event_exact/continuous_comparators.hpp"
#include "sextant/event_exact/continuous_estimator.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"

namespace sextant {

/// Drive and plant as one hybrid system: the plant's differential equation with the drive's estimator
/// and a meter of its energies appended, and the comparators whose events switch the inverter. This is what a
/// variable-step block diagram of the paper's Figure 1 computes. An engine moves the state; the owner handles
/// its events.
///
/// The gates are always driven: event-exact runs have no drive states and no protections of their own.
class EventExactSystem {
 public:
  using Plant = DrivePlant<double, AppendedPair<ContinuousEstimator, EnergyMeter<double>>>;
  using State = Plant::State;
  using Jacobian = Plant::Jacobian;
  using Events = ContinuousComparators::Events;
  static constexpr int size = Plant::size;
  static constexpr bool last_is_uncontrolled = Plant::last_is_uncontrolled;
  static constexpr int event_count = ContinuousComparators::event_count;
  /// Index of the energy meter's first state.
  static constexpr int meter = Plant::appended + ContinuousEstimator::size;
  static constexpr int psi_alpha = Plant::appended + int(ContinuousEstimator::psi_alpha);
  static constexpr int psi_beta = Plant::appended + int(ContinuousEstimator::psi_beta);
  static constexpr int torque_reference = Plant::appended + int(ContinuousEstimator::torque_reference);

  EventExactSystem(const DrivePlantParameters<>& plant, const DirectTorqueController<>::Parameters& control,
                   double sector_mask) noexcept
      : plant_{plant, {ContinuousEstimator{control.machine.r_s}, EnergyMeter<double>{}}},
        comparators_{control, sector_mask},
        torque_gain_{1.5 * control.machine.pole_pairs},
        rotor_share_{plant.machine.l_m / plant.machine.l_s()} {}

  void derivative(const State& x, State& dx) const noexcept { plant_.derivative(x, dx); }
  void jacobian(const State& x, Jacobian& j) const noexcept { plant_.jacobian(x, j); }
  void events(const State& x, Events& g) const noexcept { g = comparators_.events(compared(x)); }
  /// One event function. [N·m or Wb]
  [[nodiscard]] double event(const State& x, int i) const noexcept {
    return comparators_.event(i, compared(x));
  }

  /// For engines: the state reached by integration.
  void continue_at(const State& x) noexcept { plant_.continue_at(x); }
  [[nodiscard]] const State& state() const noexcept { return plant_.state(); }

  /// Switches until nothing is left to cross and gives the inverter its state; true when that changed.
  /// `event`: the one that an engine has just stopped at, or −1.
  bool settle(int event) noexcept {
    if (!comparators_.settle(compared(plant_.state()), event)) return false;
    PlantInputs<> inputs = plant_.inputs();
    inputs.state = comparators_.state();
    plant_.set_inputs(inputs);
    return true;
  }

  /// Torque reference from now on: a straight line. [N·m], [N·m/s]
  void set_reference(double torque, double slope) noexcept {
    State x = plant_.state();
    x[torque_reference] = torque;
    plant_.continue_at(x);
    plant_.appended_system().first.set_reference_slope(slope);
  }

  /// Surroundings of the plant from now on; the switching state is the comparators'.
  void set_surroundings(double u_dc, double tau_l, bool imposed_speed, double speed_slope) noexcept {
    plant_.set_inputs({comparators_.state(), u_dc, tau_l, imposed_speed, speed_slope});
  }
  void set_speed(double omega_m) noexcept { plant_.set_speed(omega_m); }

  /// Magnetised at standstill by direct current along phase a: i_s = ψ_s/L_s, ψ_r = L_m i_s. [Wb]
  void magnetise(double psi_s) noexcept {
    State x = plant_.state();
    x[Plant::psi_s_alpha] = psi_s;
    x[Plant::psi_r_alpha] = rotor_share_ * psi_s;
    x[psi_alpha] = psi_s;
    plant_.set_state(x);
  }

  [[nodiscard]] const Plant& plant() const noexcept { return plant_; }
  [[nodiscard]] const ContinuousComparators& comparators() const noexcept { return comparators_; }
  /// Stator flux linkage as estimated. [Wb]
  [[nodiscard]] SpaceVector<> estimated_flux() const noexcept {
    return {plant_.state()[psi_alpha], plant_.state()[psi_beta]};
  }
  /// Torque as estimated, 3/2 p̂ ψ̂_s × i_s. [N·m]
  [[nodiscard]] double estimated_torque(SpaceVector<> psi_s, SpaceVector<> i_s) const noexcept {
    return torque_gain_ * cross(psi_s, i_s);
  }
  /// Torque reference at this instant. [N·m]
  [[nodiscard]] double reference() const noexcept { return plant_.state()[torque_reference]; }

 private:
  [[nodiscard]] ContinuousComparators::Inputs compared(const State& x) const noexcept {
    const SpaceVector<> estimate{x[psi_alpha], x[psi_beta]};
    const SpaceVector<> i_s = plant_.stator_current(x);
    return {estimate, estimated_torque(estimate, i_s), x[torque_reference]};
  }

  Plant plant_;
  ContinuousComparators comparators_;
  double torque_gain_;  ///< 3/2 p̂ [-]
  double rotor_share_;  ///< L_m/L_s [-]
};

}  // namespace sextant
