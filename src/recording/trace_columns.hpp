#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "sextant/recording/trace_row.hpp"

namespace sextant {

static_assert(std::is_trivially_copyable_v<TraceRow> && std::is_standard_layout_v<TraceRow>);

enum class ColumnType : std::uint8_t { float64, int64, uint32, uint8, int8, drive_state };

template <class T>
[[nodiscard]] constexpr ColumnType column_type() noexcept {
  if constexpr (std::is_same_v<T, double>) return ColumnType::float64;
  if constexpr (std::is_same_v<T, std::int64_t>) return ColumnType::int64;
  if constexpr (std::is_same_v<T, std::uint32_t>) return ColumnType::uint32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return ColumnType::uint8;
  if constexpr (std::is_same_v<T, std::int8_t>) return ColumnType::int8;
  if constexpr (std::is_same_v<T, DriveState>) return ColumnType::drive_state;
}

/// One signal of the trace: a dataset, and where its value lies in a row.
struct TraceColumn {
  const char* folder;  // HDF5 group of the file; empty: its root
  const char* name;
  const char* group;  // signals that are chosen together
  const char* unit;
  const char* description;
  ColumnType type;
  std::size_t offset;  // [byte]
  std::size_t size;    // [byte]

  [[nodiscard]] std::string path() const { return *folder == '\0' ? name : std::string{folder} + '/' + name; }
};

#define SEXTANT_COLUMN(folder, member_of, member, group, unit, description)                          \
  TraceColumn {                                                                                      \
    folder, #member, group, unit, description, column_type<decltype(TraceRow{}.member_of.member)>(), \
        offsetof(TraceRow, member_of) + offsetof(decltype(TraceRow{}.member_of), member),            \
        sizeof(TraceRow{}.member_of.member)                                                          \
  }
#define SEXTANT_DRIVE(member, unit, description) \
  SEXTANT_COLUMN("", drive, member, "standard", unit, description),
#define SEXTANT_PLANT(member, group, unit, description) \
  SEXTANT_COLUMN("plant", plant, member, group, unit, description)
#define SEXTANT_JUNCTION(member, device)  \
  SEXTANT_PLANT(member, "inverter", "°C", \
                "temperature of the junction of the " device "; NaN without plant.inverter.losses")
#define SEXTANT_CONTROL(member, unit, description) \
  SEXTANT_COLUMN("control", control, member, "comparators", unit, description)

/// Every signal; the first, the time, is in every trace.
inline constexpr std::array trace_columns{
    // clang-format off
    SEXTANT_TELEMETRY_MEMBERS(SEXTANT_DRIVE)
    // clang-format on
    SEXTANT_PLANT(torque_nm, "standard", "N·m", "air-gap torque"),
    SEXTANT_PLANT(torque_mean_nm, "standard", "N·m", "air-gap torque, mean over the interval"),
    SEXTANT_PLANT(torque_min_nm, "standard", "N·m", "air-gap torque, minimum over the interval"),
    SEXTANT_PLANT(torque_max_nm, "standard", "N·m", "air-gap torque, maximum over the interval"),
    SEXTANT_PLANT(psi_s_wb, "standard", "Wb", "magnitude of the stator flux linkage"),
    SEXTANT_PLANT(flux_mean_wb, "standard", "Wb",
                  "magnitude of the stator flux linkage, mean over the interval"),
    SEXTANT_PLANT(flux_min_wb, "standard", "Wb",
                  "magnitude of the stator flux linkage, minimum over the interval"),
    SEXTANT_PLANT(flux_max_wb, "standard", "Wb",
                  "magnitude of the stator flux linkage, maximum over the interval"),
    SEXTANT_PLANT(psi_s_alpha_wb, "standard", "Wb", "stator flux linkage, stationary frame, along phase a"),
    SEXTANT_PLANT(psi_s_beta_wb, "standard", "Wb", "stator flux linkage, stationary frame, 90 degrees ahead"),
    SEXTANT_PLANT(psi_r_alpha_wb, "standard", "Wb", "rotor flux linkage, stationary frame, along phase a"),
    SEXTANT_PLANT(psi_r_beta_wb, "standard", "Wb", "rotor flux linkage, stationary frame, 90 degrees ahead"),
    SEXTANT_PLANT(current_min_a, "standard", "A",
                  "magnitude of the stator current vector, minimum over the interval"),
    SEXTANT_PLANT(current_max_a, "standard", "A",
                  "magnitude of the stator current vector, maximum over the interval"),
    SEXTANT_PLANT(i_a_a, "standard", "A", "current of phase a"),
    SEXTANT_PLANT(i_b_a, "standard", "A", "current of phase b"),
    SEXTANT_PLANT(i_c_a, "standard", "A", "current of phase c"),
    SEXTANT_PLANT(u_dc_v, "standard", "V", "DC-link voltage"),
    SEXTANT_PLANT(omega_m_rad_s, "standard", "rad/s", "mechanical speed"),
    SEXTANT_PLANT(tau_l_nm, "standard", "N·m", "load torque"),
    SEXTANT_PLANT(switch_a, "switching", "1", "leg a: 1 upper switch on, 0 lower switch on, -1 both off"),
    SEXTANT_PLANT(switch_b, "switching", "1", "leg b: 1 upper switch on, 0 lower switch on, -1 both off"),
    SEXTANT_PLANT(switch_c, "switching", "1", "leg c: 1 upper switch on, 0 lower switch on, -1 both off"),
    SEXTANT_PLANT(u_s_alpha_v, "voltage", "V", "stator voltage, stationary frame, along phase a"),
    SEXTANT_PLANT(u_s_beta_v, "voltage", "V", "stator voltage, stationary frame, 90 degrees ahead"),
    SEXTANT_PLANT(
        i_dc_a, "link", "A",
        "current drawn from the DC link at the end of the interval, without that of plant.inverter.losses"),
    SEXTANT_PLANT(i_r_alpha_a, "rotor", "A",
                  "rotor current, referred to the stator, stationary frame, along phase a"),
    SEXTANT_PLANT(i_r_beta_a, "rotor", "A",
                  "rotor current, referred to the stator, stationary frame, 90 degrees ahead"),
    SEXTANT_PLANT(theta_m_rad, "shaft", "rad", "mechanical angle of the shaft, not wrapped"),
    SEXTANT_PLANT(shaft_torque_nm, "driveline", "N·m",
                  "torque of the shaft to the load, referred to the motor's shaft; the load torque without a "
                  "driveline"),
    SEXTANT_PLANT(load_speed_rad_s, "driveline", "rad/s",
                  "speed of the load, referred to the motor's shaft; that of the motor without a driveline"),
    SEXTANT_PLANT(energy_link_j, "energy", "J", "energy drawn from the DC link since the run began"),
    SEXTANT_PLANT(
        energy_copper_j, "energy", "J",
        "energy lost in the windings, and in switches and diodes that have drops, since the run began"),
    SEXTANT_PLANT(energy_iron_j, "energy", "J", "energy lost in the iron since the run began"),
    SEXTANT_PLANT(energy_shaft_j, "energy", "J", "work of the air-gap torque since the run began"),
    SEXTANT_PLANT(energy_field_j, "energy", "J", "energy of the magnetic field"),
    SEXTANT_PLANT(winding_temperature_c, "thermal", "°C",
                  "temperature of the stator winding; NaN without plant.thermal"),
    SEXTANT_PLANT(rotor_temperature_c, "thermal", "°C",
                  "temperature of the rotor; NaN without plant.thermal"),
    SEXTANT_PLANT(housing_temperature_c, "thermal", "°C",
                  "temperature of the housing; NaN without plant.thermal"),
    SEXTANT_PLANT(
        energy_inverter_j, "energy", "J",
        "energy drawn from the DC link for what switches and diodes lose beyond their drops since the "
        "run began; 0 without plant.inverter.losses"),
    SEXTANT_PLANT(inverter_loss_w, "inverter", "W",
                  "loss of all switches and diodes, mean over a control period; NaN without "
                  "plant.inverter.losses"),
    SEXTANT_PLANT(case_temperature_c, "inverter", "°C",
                  "temperature of the case of switches and diodes; NaN without plant.inverter.losses"),
    SEXTANT_JUNCTION(junction_a_upper_switch_c, "upper switch of leg a"),
    SEXTANT_JUNCTION(junction_a_upper_diode_c, "upper diode of leg a"),
    SEXTANT_JUNCTION(junction_a_lower_switch_c, "lower switch of leg a"),
    SEXTANT_JUNCTION(junction_a_lower_diode_c, "lower diode of leg a"),
    SEXTANT_JUNCTION(junction_b_upper_switch_c, "upper switch of leg b"),
    SEXTANT_JUNCTION(junction_b_upper_diode_c, "upper diode of leg b"),
    SEXTANT_JUNCTION(junction_b_lower_switch_c, "lower switch of leg b"),
    SEXTANT_JUNCTION(junction_b_lower_diode_c, "lower diode of leg b"),
    SEXTANT_JUNCTION(junction_c_upper_switch_c, "upper switch of leg c"),
    SEXTANT_JUNCTION(junction_c_upper_diode_c, "upper diode of leg c"),
    SEXTANT_JUNCTION(junction_c_lower_switch_c, "lower switch of leg c"),
    SEXTANT_JUNCTION(junction_c_lower_diode_c, "lower diode of leg c"),
    SEXTANT_CONTROL(torque_comparator, "1", "torque comparator: 1 raise the torque, -1 lower it, 0 hold"),
    SEXTANT_CONTROL(flux_comparator, "1", "flux comparator: 1 raise the flux, 0 lower it"),
    SEXTANT_COLUMN(
        "control", control, torque_monitored_nm, "monitor", "N·m",
        "mean torque by the torque monitor; 0 without torque production, or in an event-exact run"),
    SEXTANT_COLUMN(
        "control", control, torque_reached_nm, "monitor", "N·m",
        "what link and machine have let the torque reach; the reference where it does not lag that; 0 in "
        "an event-exact run"),
    SEXTANT_COLUMN("control", control, r_s_ohm, "parameters", "Ω",
                   "stator resistance in use by the controller; 0 where it tells none"),
    SEXTANT_COLUMN("control", control, r_r_ohm, "parameters", "Ω",
                   "rotor resistance in use by the controller; 0 where it tells none"),
    SEXTANT_COLUMN("control", control, l_m_h, "parameters", "H",
                   "magnetising inductance in use by the controller; 0 where it tells none"),
    SEXTANT_COLUMN("control", control, r_s_deviation, "parameters", "1",
                   "relative standard deviation of r_s_ohm; 0 where the controller tells none"),
    SEXTANT_COLUMN("control", control, r_r_deviation, "parameters", "1",
                   "relative standard deviation of r_r_ohm; 0 where the controller tells none"),
    SEXTANT_COLUMN("control", control, l_m_deviation, "parameters", "1",
                   "relative standard deviation of l_m_h; 0 where the controller tells none"),
    SEXTANT_COLUMN("control", control, periods_unchecked, "monitor", "1",
                   "control periods so far, legs driven, left out by the checks of currents and speed"),
};

/// Those of the drive, which stand first.
inline constexpr std::span drive_columns{
    trace_columns.data(), std::size_t(std::count_if(trace_columns.begin(), trace_columns.end(),
                                                    [](const TraceColumn& c) { return *c.folder == '\0'; }))};

/// Those of a controller's channels.
[[nodiscard]] inline std::vector<TraceColumn> channel_columns(std::span<const ControlChannel> channels) {
  constexpr std::size_t begin = offsetof(TraceRow, control) + offsetof(ControlRow, channels);
  std::vector<TraceColumn> columns;
  for (const ControlChannel& c : channels.first(std::min(channels.size(), control_channel_capacity))) {
    columns.push_back({"control", c.name, "standard", c.unit, c.description, ColumnType::float64,
                       begin + columns.size() * sizeof(double), sizeof(double)});
  }
  return columns;
}

#undef SEXTANT_CONTROL
#undef SEXTANT_JUNCTION
#undef SEXTANT_PLANT
#undef SEXTANT_DRIVE
#undef SEXTANT_COLUMN

}  // namespace sextant
