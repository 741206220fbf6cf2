#pragma once

#include <optional>

#include "sextant/control/flux_estimator_kind.hpp"
#include "sextant/core/drive_basis.hpp"
#include "sextant/core/winding_resistance.hpp"
#include "sextant/drive/capability_setup.hpp"
#include "sextant/drive/command_setup.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/drive/protection_setup.hpp"
#include "sextant/drive/torque_monitor_setup.hpp"

namespace sextant {

/// A drive as its user describes it: the basis once, what follows from nothing else, and values that follow
/// unless they are given. `resolved` makes the parameters of it. Values mean what the part's parameters say;
/// so do the defaults.
template <class T = double>
struct DriveSetup {
  DriveBasis<T> basis{};             ///< but for `inverter.voltage_error`, which is the member below
  std::optional<T> voltage_error{};  ///< of the inverter [V]
  FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
  bool adapts_parameters{true};    ///< as `ControlBasis`
  WindingResistance<T> winding{};  ///< the same
  bool magnetise_first{typename Drive<T>::Parameters{}.magnetise_first};
  std::optional<T> magnetise_timeout_ms{};  ///< [ms]
  std::optional<T> current_limit{};         ///< of the capability and of what the control method asks for [A]
  CommandSetup<T> command{};
  CapabilitySetup<T> capability{};
  ProtectionSetup<T> protection{};
  TorqueMonitorSetup<T> torque_monitor{};
  typename OptimalFlux<T>::Parameters optimal_flux{};
  AntiJerkParameters<T> anti_jerk{};

  /// What is wrong with the basis, or null. `ResolvedDrive` checks the rest.
  [[nodiscard]] const char* validate() const noexcept {
    if (basis.inverter.voltage_error != T(0)) {
      return "the voltage error of a setup's inverter is given as voltage_error of the setup";
    }
    if (const char* problem = basis.validate()) return problem;
    const bool feeds = zero_torque_speed(basis.machine, basis.flux_reference, basis.u_dc) > T(0);
    return feeds ? nullptr : "the link cannot feed the flux reference even at standstill";
  }
};

}  // namespace sextant
