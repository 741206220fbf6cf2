#pragma once

#include <cstdint>
#include <optional>

#include "sextant/control/flux_estimator_kind.hpp"
#include "sextant/core/drive_basis.hpp"
#include "sextant/drive/drive.hpp"

namespace sextant {

// Of each part what a user may say. An optional value follows from others by the rules of resolved.hpp
// unless it is given. Values mean what the part's parameters say; so do the defaults.

/// Of `CommandLimits`.
template <class T = double>
struct CommandSetup {
  std::optional<T> torque_limit{};  ///< [N·m]
  T torque_rate{CommandLimits<T>{}.torque_rate};
  std::int64_t timeout_ns{CommandLimits<T>{}.timeout_ns};
  std::int64_t zero_ramp_ns{CommandLimits<T>{}.zero_ramp_ns};
  std::int64_t lost_ns{CommandLimits<T>{}.lost_ns};
  std::int64_t status_timeout_ns{CommandLimits<T>{}.status_timeout_ns};
  std::int64_t status_lost_ns{CommandLimits<T>{}.status_lost_ns};
  std::uint32_t blocked_limit{CommandLimits<T>{}.blocked_limit};
};

/// Of `TorqueCapability`.
template <class T = double>
struct CapabilitySetup {
  using Parameters = typename TorqueCapability<T>::Parameters;

  std::optional<T> torque{};         ///< [N·m]
  std::optional<T> current_limit{};  ///< also of what the control method asks for [A]
  T voltage_use{Parameters{}.voltage_use};
  T breakdown_use{Parameters{}.breakdown_use};
  T base_speed{Parameters{}.base_speed};
  T zero_torque_speed{Parameters{}.zero_torque_speed};
};

/// Of `ProtectionLimits`.
template <class T = double>
struct ProtectionSetup {
  std::optional<T> over_current{};      ///< [A]
  std::optional<T> dc_over_voltage{};   ///< [V]
  std::optional<T> over_speed{};        ///< [rad/s]
  std::optional<T> dc_under_voltage{};  ///< [V]

  std::optional<T> current_range{};  ///< [A]
  std::optional<T> voltage_range{};  ///< [V]
  std::optional<T> speed_range{};    ///< [rad/s]

  std::optional<T> current_sum{};  ///< [A]
  T current_gain_tolerance{ProtectionLimits<T>{}.current_gain_tolerance};
  std::optional<T> current_offset{};  ///< [A]
  std::optional<T> current_jump{};    ///< [A]
  T current_response{ProtectionLimits<T>{}.current_response};
  std::optional<T> current_noise{};  ///< [A]
  std::optional<T> zero_current{};   ///< [A]
  std::optional<T> current_step{};   ///< [A]

  std::optional<T> speed_jump{};   ///< [rad/s]
  std::optional<T> speed_error{};  ///< [rad/s]
  std::int64_t speed_error_ns{ProtectionLimits<T>{}.speed_error_ns};

  T flux_lost_share{ProtectionLimits<T>{}.flux_lost_share};
  std::optional<T> flux_lost_torque{};  ///< [N·m]
  std::int64_t flux_lost_ns{ProtectionLimits<T>{}.flux_lost_ns};

  T winding_warning{ProtectionLimits<T>{}.winding_warning};
  T winding_trip{ProtectionLimits<T>{}.winding_trip};
  typename WindingTemperature<T>::Parameters winding{};
};

/// Of `TorqueMonitorLimits`.
template <class T = double>
struct TorqueMonitorSetup {
  bool enabled{TorqueMonitorLimits<T>{}.enabled};
  std::optional<InductionMachineParameters<T>> machine{};  ///< by default that of the basis
  std::optional<T> limit{};                                ///< [N·m]
  T limit_share{TorqueMonitorLimits<T>{}.limit_share};
  std::optional<T> wrong_sign{};  ///< [N·m]
  std::int64_t time_ns{TorqueMonitorLimits<T>{}.time_ns};
  T r_s_share{TorqueMonitorLimits<T>{}.r_s_share};
  T r_r_share{TorqueMonitorLimits<T>{}.r_r_share};
  T l_m_share{TorqueMonitorLimits<T>{}.l_m_share};
  T sensor_share{TorqueMonitorLimits<T>{}.sensor_share};
};

/// A drive as its user describes it: the basis once, what follows from nothing else, and values that follow
/// unless they are given. `resolved` makes the parameters of it.
template <class T = double>
struct DriveSetup {
  DriveBasis<T> basis{};             ///< but for `inverter.voltage_error`, which is the member below
  std::optional<T> voltage_error{};  ///< of the inverter [V]
  FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
  bool adapts_parameters{true};  ///< as `ControlBasis`
  bool magnetise_first{typename Drive<T>::Parameters{}.magnetise_first};
  std::optional<T> magnetise_timeout_ms{};  ///< [ms]
  CommandSetup<T> command{};
  CapabilitySetup<T> capability{};
  ProtectionSetup<T> protection{};
  TorqueMonitorSetup<T> torque_monitor{};
  typename OptimalFlux<T>::Parameters optimal_flux{};

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
