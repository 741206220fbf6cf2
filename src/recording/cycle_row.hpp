#pragma once

#include <cstdint>

#include "hdf5_handle.hpp"
#include "sextant/drive/cycle_record.hpp"

namespace sextant {

/// A gate pattern as the file holds it: state by SwitchState::code(), duration [ns], and how many of them.
struct PatternRow {
  std::uint8_t segments{};
  std::uint8_t state[GatePattern::capacity]{};
  std::int32_t duration_ns[GatePattern::capacity]{};
};

/// A CycleRecord as the file holds it, a member a column.
struct CycleRow {
  std::int64_t t_ns{};
  double i_a_a{};
  double i_b_a{};
  double i_c_a{};
  double u_dc_v{};
  double speed_rad_s{};
  double theta_m_rad{};
  std::uint8_t has_theta_m{};
  double winding_temperature_c{};
  std::uint8_t has_winding_temperature{};
  std::uint8_t plausible{};
  PatternRow applied{};
  double torque_nm{};
  double torque_limit_nm{};
  std::uint8_t enable{};
  std::uint8_t fault_reset{};
  std::int64_t received_ns{};
  std::uint64_t command_sequence{};
  std::uint32_t disables{};
  std::uint32_t resets{};
  std::uint32_t rejected{};
  std::uint8_t counter{};
  std::uint8_t e2e{};
  std::uint32_t out_of_range{};
  std::uint8_t bus_off{};
  std::uint8_t second_sender{};
  std::uint8_t shutdown{};
  std::int64_t status_age_ns{};
  std::uint64_t external{};  ///< bits of the faults
  PatternRow pattern{};
};

[[nodiscard]] CycleRow to_row(const CycleRecord<double>& record) noexcept;
[[nodiscard]] CycleRecord<double> to_record(const CycleRow& row) noexcept;

/// The type of a row in the file and in memory.
[[nodiscard]] hdf5::Handle cycle_row_type();

}  // namespace sextant
