#pragma once

#include "sextant/core/space_vector.hpp"
#include "sextant/core/telemetry_interval.hpp"

namespace sextant {

/// The true values of the plant, at the instant of the telemetry they are recorded with.
struct PlantSample {
  double torque{};        ///< air-gap torque [N·m]
  double tau_l{};         ///< load torque [N·m]
  SpaceVector<> psi_s{};  ///< stator flux linkage, stationary frame [Wb]
  SpaceVector<> psi_r{};  ///< rotor flux linkage, stationary frame [Wb]
  ThreePhase<> i_abc{};   ///< phase currents, positive into the machine [A]
  double u_dc{};          ///< DC-link voltage [V]
  double omega_m{};       ///< mechanical speed [rad/s]
};

/// The plant's true values of one row of a trace. Without a word on it a value is that of the row's end.
struct PlantRow {
  double torque_nm{};       ///< air-gap torque [N·m]
  double torque_mean_nm{};  ///< over the interval [N·m]
  double torque_min_nm{};   ///< over the interval [N·m]
  double torque_max_nm{};   ///< over the interval [N·m]
  double psi_s_wb{};        ///< magnitude of the stator flux linkage [Wb]
  double flux_mean_wb{};    ///< of that, over the interval [Wb]
  double flux_min_wb{};     ///< of that, over the interval [Wb]
  double flux_max_wb{};     ///< of that, over the interval [Wb]
  double psi_s_alpha_wb{};  ///< [Wb]
  double psi_s_beta_wb{};   ///< [Wb]
  double psi_r_alpha_wb{};  ///< [Wb]
  double psi_r_beta_wb{};   ///< [Wb]
  double current_min_a{};   ///< magnitude of the stator current vector, over the interval [A]
  double current_max_a{};   ///< the same [A]
  double i_a_a{};           ///< [A]
  double i_b_a{};           ///< [A]
  double i_c_a{};           ///< [A]
  double u_dc_v{};          ///< [V]
  double omega_m_rad_s{};   ///< [rad/s]
  double tau_l_nm{};        ///< [N·m]
};

/// One row of a trace: what the drive knew over an interval and what was true.
struct TraceRow {
  TelemetryIntervalRecord<double> drive{};
  PlantRow plant{};
};

}  // namespace sextant
