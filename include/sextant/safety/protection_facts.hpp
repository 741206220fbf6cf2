#pragma once

#include "sextant/core/measurement.hpp"
#include "sextant/safety/current_response.hpp"
#include "sextant/safety/direction_check.hpp"
#include "sextant/safety/phase_continuity.hpp"
#include "sextant/safety/speed_plausibility.hpp"

namespace sextant {

/// Input of the protections beside the measurement: what the drive did with the one before, and the flux.
template <class T = double>
struct ProtectionInputs {
  bool makes_torque{false};  ///< the drive follows a torque reference
  T torque_reference{};      ///< [N·m]
  T flux_reference{};        ///< of the stator [Wb]
  T torque{};                ///< controller's estimate [N·m]
  T psi_s{};                 ///< controller's estimate of |ψ_s| [Wb]
  SpaceVector<T> psi_r{};    ///< rotor flux by the torque monitor, at this measurement, stationary frame [Wb]
  T psi_r_error{};           ///< by how much that may be wrong [Wb]
};

/// Inputs of the protection rules in one control period: the measurement, and what the monitors made of it.
template <class T = double>
struct ProtectionFacts {
  const Measurement<T>& measurement;
  const ProtectionInputs<T>& drive;
  const CurrentResponse<T>& response;
  const PhaseContinuity<T>& continuity;
  const SpeedPlausibility<T>& speed;
  const DirectionCheck<T>& direction;
  bool is_driven{false};  ///< every leg was driven since the last measurement
  bool flux_was_built{
      false};  ///< the flux has reached its reference, less a fifth, since torque production began
  unsigned unresponsive_phases{};  ///< that do not respond to the voltage, bit n for phase n
  unsigned answering_phases{};     ///< that respond to changes of the voltage, bit n for phase n
  T current_peak{};                ///< largest magnitude of a phase current [A]
  T current_sum{};                 ///< magnitude of the sum of the phase currents [A]
  T current_offset{};              ///< largest magnitude of an offset of a phase, at rest [A]
  T speed_change{};                ///< magnitude of the change a control period, gates driven [rad/s]
  T winding_temperature{};         ///< [°C]
};

}  // namespace sextant
