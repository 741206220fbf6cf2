#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sextant/control/controller.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/plant/inverter_losses.hpp"
#include "sextant/plant/thermal_parameters.hpp"
#include "sextant/recording/energy_account.hpp"
#include "sextant/recording/load_sample.hpp"

namespace sextant {

/// The inverter's losses and temperatures at one instant; NaN: not known.
struct InverterSample {
  static constexpr double unknown = DriveEnergies::unknown;
  double loss{unknown};              ///< mean over the control period that ends there [W]
  double case_temperature{unknown};  ///< [°C]
  PerDevice<double> junctions{unknown, unknown, unknown, unknown, unknown, unknown,
                              unknown, unknown, unknown, unknown, unknown, unknown};  ///< [°C]
};

/// The true values of the plant, at the instant of the telemetry they are recorded with.
struct PlantSample {
  double torque{};        ///< air-gap torque [N·m]
  double tau_l{};         ///< load torque [N·m]
  SpaceVector<> psi_s{};  ///< stator flux linkage, stationary frame [Wb]
  SpaceVector<> psi_r{};  ///< rotor flux linkage, stationary frame [Wb]
  ThreePhase<> i_abc{};   ///< phase currents, positive into the machine [A]
  double u_dc{};          ///< DC-link voltage [V]
  double omega_m{};       ///< mechanical speed [rad/s]
  double theta_m{};       ///< mechanical angle, not wrapped [rad]
  double i_dc{};          ///< drawn from the DC link [A]
  SwitchState state{};    ///< of the inverter, in force up to this instant
  SpaceVector<> u_s{};    ///< stator voltage, stationary frame [V]
  SpaceVector<> i_r{};    ///< rotor current, referred to the stator, stationary frame [A]
  DriveEnergies energies{};
  /// Of the machine; NaN: not known. [°C]
  ThermalNodes<double> temperatures{DriveEnergies::unknown, DriveEnergies::unknown, DriveEnergies::unknown};
  LoadSample load{};
  InverterSample inverter{};
};

/// What a controller gives to a trace beside its telemetry, in one control period.
struct ControlSample {
  std::int8_t torque_comparator{};     ///< of direct torque control; zero where a run has none [-]
  std::int8_t flux_comparator{};       ///< the same [-]
  std::span<const double> channels{};  ///< at most `control_channel_capacity`
};

/// The plant's true values of one row of a trace. Without a word on it a value is that of the row's end.
struct PlantRow {
  double torque_nm{};                  ///< air-gap torque [N·m]
  double torque_mean_nm{};             ///< over the interval [N·m]
  double torque_min_nm{};              ///< over the interval [N·m]
  double torque_max_nm{};              ///< over the interval [N·m]
  double psi_s_wb{};                   ///< magnitude of the stator flux linkage [Wb]
  double flux_mean_wb{};               ///< of that, over the interval [Wb]
  double flux_min_wb{};                ///< of that, over the interval [Wb]
  double flux_max_wb{};                ///< of that, over the interval [Wb]
  double psi_s_alpha_wb{};             ///< [Wb]
  double psi_s_beta_wb{};              ///< [Wb]
  double psi_r_alpha_wb{};             ///< [Wb]
  double psi_r_beta_wb{};              ///< [Wb]
  double current_min_a{};              ///< magnitude of the stator current vector, over the interval [A]
  double current_max_a{};              ///< the same [A]
  double i_a_a{};                      ///< [A]
  double i_b_a{};                      ///< [A]
  double i_c_a{};                      ///< [A]
  double u_dc_v{};                     ///< [V]
  double omega_m_rad_s{};              ///< [rad/s]
  double tau_l_nm{};                   ///< [N·m]
  double theta_m_rad{};                ///< mechanical angle, not wrapped [rad]
  double shaft_torque_nm{};            ///< of the shaft to the load, referred to the motor's [N·m]
  double load_speed_rad_s{};           ///< of the load, referred to the motor's shaft [rad/s]
  double i_dc_a{};                     ///< drawn from the DC link at this instant [A]
  double u_s_alpha_v{};                ///< [V]
  double u_s_beta_v{};                 ///< [V]
  double i_r_alpha_a{};                ///< [A]
  double i_r_beta_a{};                 ///< [A]
  double energy_link_j{};              ///< drawn from the DC link since the run began [J]
  double energy_copper_j{};            ///< lost in the windings, and in switches and diodes, since then [J]
  double energy_iron_j{};              ///< lost in the iron since then [J]
  double energy_shaft_j{};             ///< work of the air-gap torque since then [J]
  double energy_field_j{};             ///< in the magnetic field [J]
  double winding_temperature_c{};      ///< of the stator winding [°C]
  double rotor_temperature_c{};        ///< [°C]
  double housing_temperature_c{};      ///< [°C]
  double energy_inverter_j{};          ///< drawn for the inverter's losses beyond its drops since then [J]
  double inverter_loss_w{};            ///< mean over the control period [W]
  double case_temperature_c{};         ///< of the inverter's devices [°C]
  double junction_a_upper_switch_c{};  ///< of that device of leg a [°C]
  double junction_a_upper_diode_c{};   ///< of that device of leg a [°C]
  double junction_a_lower_switch_c{};  ///< of that device of leg a [°C]
  double junction_a_lower_diode_c{};   ///< of that device of leg a [°C]
  double junction_b_upper_switch_c{};  ///< of that device of leg b [°C]
  double junction_b_upper_diode_c{};   ///< of that device of leg b [°C]
  double junction_b_lower_switch_c{};  ///< of that device of leg b [°C]
  double junction_b_lower_diode_c{};   ///< of that device of leg b [°C]
  double junction_c_upper_switch_c{};  ///< of that device of leg c [°C]
  double junction_c_upper_diode_c{};   ///< of that device of leg c [°C]
  double junction_c_lower_switch_c{};  ///< of that device of leg c [°C]
  double junction_c_lower_diode_c{};   ///< of that device of leg c [°C]
  std::int8_t switch_a{};  ///< 1: the upper switch of the leg is on, 0: the lower one, −1: none [-]
  std::int8_t switch_b{};  ///< [-]
  std::int8_t switch_c{};  ///< [-]
};

/// What the drive decides and estimates beside its telemetry, of one row of a trace.
struct ControlRow {
  std::int8_t torque_comparator{};  ///< +1: raise the torque, −1: lower it, 0: hold [-]
  std::int8_t flux_comparator{};    ///< 1: raise the flux, 0: lower it [-]
  double torque_monitored_nm{};     ///< mean torque by the torque monitor [N·m]
  double torque_reached_nm{};       ///< what link and machine have let the torque reach [N·m]
  double r_s_ohm{};                 ///< stator resistance in use [Ω]
  double r_r_ohm{};                 ///< rotor resistance in use [Ω]
  double l_m_h{};                   ///< magnetising inductance in use [H]
  double r_s_deviation{};           ///< relative standard deviation of `r_s_ohm` [-]
  double r_r_deviation{};           ///< the same of `r_r_ohm` [-]
  double l_m_deviation{};           ///< the same of `l_m_h` [-]
  double periods_unchecked{};       ///< left out by the checks of currents and speed so far [-]
  std::array<double, control_channel_capacity> channels{};  ///< of an own controller, each in its unit
};

/// One row of a trace: what the drive knew over an interval and what was true.
struct TraceRow {
  TelemetryIntervalRecord<double> drive{};
  PlantRow plant{};
  ControlRow control{};
};

}  // namespace sextant
