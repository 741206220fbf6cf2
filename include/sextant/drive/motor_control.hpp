#pragma once

#include <concepts>
#include <cstdint>

#include "sextant/control/controller.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/drive/available_torque.hpp"

namespace sextant {

/// What the drive wants of its motor in the coming period.
template <class T = double>
struct MotorDemand {
  ControlMode mode{ControlMode::off};
  T torque{};               ///< torque reference, 0 but in mode `torque` [N·m]
  T steady_torque{};        ///< the same without what damps the shaft: the flux follows this one [N·m]
  bool at_present_limit{};  ///< it is what `present_limit` allows, or more
  bool limited{};           ///< less torque is made than requested
};

/// A motor with its control: the part of a `Drive` that depends on the kind of machine. It owns estimate,
/// controller, flux reference and what these allow of torque. Once a period the drive asks `available`, then
/// `present_limit` while torque is made, and makes the `step`; each ends within the period without heap, lock
/// or exception. Torques are those of the shaft, positive in the direction of positive speed.
///
/// `Parameters`: by default valid; `validate(timing)` and, of the parts that the motor is constructed with
/// beside them, `validate_with(timing, parts…)`; `inertia()` [kg·m²].
/// `available(measurement, dt)`: the torque of a steady state. dt: since the last one [s].
/// `present_limit(enough)`: the largest torque by the present state; none where it is at least `enough`.
/// [N·m]
/// `step(measurement, demand, dt)`: the pattern of the coming period, which fills it. In FAULT the
/// measurement has no currents, and a pattern that is off. Modes other than `torque` make none; the gates are
/// off in mode `off`.
/// `discard_pattern()`: the pattern of the last step was none, and the gates are off instead.
/// `restart()`: a fault is over, which may have misled the estimate.
/// `takes_parameters()`: whether `take_parameters(from)` takes what may always change (`Changes`) from a
/// motor of which the rest is the same, between two periods; what follows from the past stays. Without it a
/// drive takes other parameters at rest alone, by a motor that begins anew. `estimate()`, `reference()`,
/// `flux_reference()`: of the last step. [Wb]
template <class Motor, class T>
concept MotorControl = std::copy_constructible<typename Motor::Parameters> &&
                       requires(Motor& motor, const Motor& asked,
                                const typename Motor::Parameters& parameters, const ControlTiming& timing,
                                const Measurement<T>& measurement, const MotorDemand<T>& demand, T x) {
                         { parameters.validate(timing) } -> std::same_as<const char*>;
                         { parameters.inertia() } -> std::same_as<T>;
                         { motor.available(measurement, x) } -> std::same_as<AvailableTorque<T>>;
                         { asked.present_limit(x) } -> std::same_as<LimitedTorque<T>>;
                         { motor.step(measurement, demand, x) } -> std::same_as<GatePattern>;
                         { motor.discard_pattern() } -> std::same_as<void>;
                         { motor.restart() } -> std::same_as<void>;
                         { asked.takes_parameters() } -> std::same_as<bool>;
                         { motor.take_parameters(asked) } -> std::same_as<void>;
                         { asked.estimate() } -> std::same_as<const ControlEstimate<T>&>;
                         { asked.reference() } -> std::same_as<const ControlReference<T>&>;
                         { asked.flux_reference() } -> std::same_as<T>;
                       };

}  // namespace sextant
