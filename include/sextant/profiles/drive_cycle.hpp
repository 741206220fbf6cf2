#pragma once

#include <optional>
#include <string>

#include "sextant/profiles/profile.hpp"

namespace sextant {

/// A drive cycle over time. Between its points both are linear, after the last they are held.
struct DriveCycle {
  ProfileParameters speed{};                 ///< of the vehicle [m/s]
  std::optional<ProfileParameters> grade{};  ///< of the road, tan α, above zero uphill [-]
};

/// A CSV file with the column `time_s`, from 0 s on and rising, one of `speed_mph`, `speed_kmh` and
/// `speed_m_s`, not below zero, and where the road is not level `grade` (tan α) or `grade_percent`; at least
/// two rows. Throws std::runtime_error with one sentence that names file, line and column.
[[nodiscard]] DriveCycle read_drive_cycle(const std::string& file);

}  // namespace sextant
