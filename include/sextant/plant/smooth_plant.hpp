#pragma once

#include <Eigen/Core>

#include "sextant/plant/mean_voltage.hpp"
#include "sextant/plant/smooth_state.hpp"

namespace sextant {

/// The smooth state of a plant whose legs are all driven (`SmoothState`), as a system that depends on the
/// time. V is gone from the equations of the fluxes, where A is left in the second order; in the torque and
/// there `MeanVoltage` stands for both.
template <class Plant>
class SmoothPlant {
 public:
  using State = typename Plant::MachineState;
  using Jacobian = Eigen::Matrix<double, Plant::machine_size, Plant::machine_size>;

  /// Gate segments that begin at the time `begin` [s], where V and A are `at_begin`; the plant must outlive
  /// this object.
  SmoothPlant(const Plant& plant, const VoltageIntegral<double>& voltage, double begin,
              const VoltageMoments<>& at_begin) noexcept
      : plant_{plant},
        smooth_state_{plant},
        voltage_{at_begin, voltage},
        begin_{begin},
        at_begin_{at_begin} {}

  /// Of the gate segments. [s]
  [[nodiscard]] double begin() const noexcept { return begin_; }

  /// Smooth state and slope at a time [s], as they are when V and A are zero where the gate segments begin.
  void from_begin(double t, const State& x, State& y, State& dy) const noexcept {
    derivative(t, x, dy);
    y = smooth_state_.machine(x, {at_begin_.v, at_begin_.a + (t - begin_) * at_begin_.v});
    dy = smooth_state_.slope(dy, -1.0 * at_begin_.v);
  }

  void derivative(double t, const State& x, State& dx) const noexcept {
    const VoltageMoments<> m = voltage_(t - begin_);
    State undriven;
    plant_.undriven_derivative(smooth_state_.machine(x, m), undriven);
    dx = smooth_state_.slope(undriven, m.v);
  }
  /// That of the machine's own state: a Newton iteration takes no other solution with it.
  void jacobian(double t, const State& x, Jacobian& j) const noexcept {
    typename Plant::State whole = Plant::State::Zero();
    whole.template head<Plant::machine_size>() = smooth_state_.machine(x, voltage_(t - begin_));
    typename Plant::Jacobian matrix;
    plant_.jacobian(whole, matrix);
    j = matrix.template topLeftCorner<Plant::machine_size, Plant::machine_size>();
  }

 private:
  const Plant& plant_;
  SmoothState<Plant> smooth_state_;
  MeanVoltage<double> voltage_;
  double begin_;  ///< [s]
  VoltageMoments<> at_begin_;
};

}  // namespace sextant
