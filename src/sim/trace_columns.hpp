#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sextant/sim/trace_row.hpp"

namespace sextant {

static_assert(std::is_trivially_copyable_v<TraceRow> && std::is_standard_layout_v<TraceRow>);

enum class ColumnType : std::uint8_t { float64, int64, uint32, uint8, drive_state };

template <class T>
[[nodiscard]] constexpr ColumnType column_type() noexcept {
  if constexpr (std::is_same_v<T, double>) return ColumnType::float64;
  if constexpr (std::is_same_v<T, std::int64_t>) return ColumnType::int64;
  if constexpr (std::is_same_v<T, std::uint32_t>) return ColumnType::uint32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return ColumnType::uint8;
  if constexpr (std::is_same_v<T, DriveState>) return ColumnType::drive_state;
}

/// One signal of the trace: a dataset, and where its value lies in a row.
struct TraceColumn {
  const char* name;
  const char* unit;
  const char* description;
  ColumnType type;
  std::size_t offset;  // [byte]
  std::size_t size;    // [byte]
};

#define SEXTANT_COLUMN(group, member, unit, description)                          \
  TraceColumn {                                                                   \
    #member, unit, description, column_type<decltype(TraceRow{}.group.member)>(), \
        offsetof(TraceRow, group) + offsetof(decltype(TraceRow{}.group), member), \
        sizeof(TraceRow{}.group.member)                                           \
  }

inline constexpr std::array drive_columns{
    SEXTANT_COLUMN(drive, t_ns, "ns", "last control period of the interval"),
    SEXTANT_COLUMN(drive, periods, "1", "control periods in the interval"),
    SEXTANT_COLUMN(drive, torque_requested_nm, "N·m", "requested torque"),
    SEXTANT_COLUMN(drive, torque_reference_nm, "N·m", "torque reference, as admitted by the command gate"),
    SEXTANT_COLUMN(drive, torque_mean_nm, "N·m", "estimated torque, mean over the interval"),
    SEXTANT_COLUMN(drive, torque_min_nm, "N·m", "estimated torque, minimum over the interval"),
    SEXTANT_COLUMN(drive, torque_max_nm, "N·m", "estimated torque, maximum over the interval"),
    SEXTANT_COLUMN(drive, flux_mean_wb, "Wb", "magnitude of the estimated stator flux linkage, mean"),
    SEXTANT_COLUMN(drive, flux_min_wb, "Wb", "magnitude of the estimated stator flux linkage, minimum"),
    SEXTANT_COLUMN(drive, flux_max_wb, "Wb", "magnitude of the estimated stator flux linkage, maximum"),
    SEXTANT_COLUMN(drive, current_mean_a, "A", "magnitude of the stator current vector, mean"),
    SEXTANT_COLUMN(drive, current_min_a, "A", "magnitude of the stator current vector, minimum"),
    SEXTANT_COLUMN(drive, current_max_a, "A", "magnitude of the stator current vector, maximum"),
    SEXTANT_COLUMN(drive, i_a_a, "A", "measured current of phase a"),
    SEXTANT_COLUMN(drive, i_b_a, "A", "measured current of phase b"),
    SEXTANT_COLUMN(drive, i_c_a, "A", "measured current of phase c"),
    SEXTANT_COLUMN(drive, flux_angle_rad, "rad",
                   "angle of the estimated stator flux from phase a, electrical"),
    SEXTANT_COLUMN(drive, speed_rad_s, "rad/s", "measured mechanical speed"),
    SEXTANT_COLUMN(drive, u_dc_v, "V", "measured DC-link voltage, mean"),
    SEXTANT_COLUMN(drive, i_dc_a, "A", "DC-link current, mean"),
    SEXTANT_COLUMN(drive, power_w, "W", "electrical power at the DC link, mean"),
    SEXTANT_COLUMN(drive, state, "1", "state of the drive"),
    SEXTANT_COLUMN(drive, sector, "1", "sector of the stator flux, 1 to 6, 0 without flux"),
    SEXTANT_COLUMN(drive, command_counter, "1", "E2E counter of the command acted on"),
    SEXTANT_COLUMN(drive, command_received_ns, "ns", "when that command was received"),
};

inline constexpr std::array plant_columns{
    SEXTANT_COLUMN(plant, torque_nm, "N·m", "air-gap torque"),
    SEXTANT_COLUMN(plant, torque_mean_nm, "N·m", "air-gap torque, mean over the interval"),
    SEXTANT_COLUMN(plant, torque_min_nm, "N·m", "air-gap torque, minimum over the interval"),
    SEXTANT_COLUMN(plant, torque_max_nm, "N·m", "air-gap torque, maximum over the interval"),
    SEXTANT_COLUMN(plant, psi_s_wb, "Wb", "magnitude of the stator flux linkage"),
    SEXTANT_COLUMN(plant, flux_mean_wb, "Wb", "magnitude of the stator flux linkage, mean over the interval"),
    SEXTANT_COLUMN(plant, flux_min_wb, "Wb",
                   "magnitude of the stator flux linkage, minimum over the interval"),
    SEXTANT_COLUMN(plant, flux_max_wb, "Wb",
                   "magnitude of the stator flux linkage, maximum over the interval"),
    SEXTANT_COLUMN(plant, psi_s_alpha_wb, "Wb", "stator flux linkage, stationary frame, along phase a"),
    SEXTANT_COLUMN(plant, psi_s_beta_wb, "Wb", "stator flux linkage, stationary frame, 90 degrees ahead"),
    SEXTANT_COLUMN(plant, psi_r_alpha_wb, "Wb", "rotor flux linkage, stationary frame, along phase a"),
    SEXTANT_COLUMN(plant, psi_r_beta_wb, "Wb", "rotor flux linkage, stationary frame, 90 degrees ahead"),
    SEXTANT_COLUMN(plant, current_min_a, "A",
                   "magnitude of the stator current vector, minimum over the interval"),
    SEXTANT_COLUMN(plant, current_max_a, "A",
                   "magnitude of the stator current vector, maximum over the interval"),
    SEXTANT_COLUMN(plant, i_a_a, "A", "current of phase a"),
    SEXTANT_COLUMN(plant, i_b_a, "A", "current of phase b"),
    SEXTANT_COLUMN(plant, i_c_a, "A", "current of phase c"),
    SEXTANT_COLUMN(plant, u_dc_v, "V", "DC-link voltage"),
    SEXTANT_COLUMN(plant, omega_m_rad_s, "rad/s", "mechanical speed"),
    SEXTANT_COLUMN(plant, tau_l_nm, "N·m", "load torque"),
};

#undef SEXTANT_COLUMN

}  // namespace sextant
