#pragma once

#include <string>

#include "sextant/sim/profile.hpp"

namespace sextant {

/// Vehicle speed over time [m/s] from a drive cycle: a CSV file with the column `time_s`, from 0 s on and
/// rising, and one of `speed_mph`, `speed_kmh` and `speed_m_s`, not below zero; at least two rows. Between
/// the rows the speed is linear, after the last it is held. Throws std::runtime_error with one sentence that
/// names file, line and column.
[[nodiscard]] ProfileParameters read_drive_cycle(const std::string& file);

}  // namespace sextant
