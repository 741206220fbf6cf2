#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "sextant/config/drive_config.hpp"

namespace sextant {

/// The largest magnitude that a profile reaches in a run of that length; the profile must be valid.
[[nodiscard]] double largest_magnitude(const ProfileParameters& profile, std::int64_t duration_ns);

/// A key that chooses among `names` and those of parts, whose meanings stand behind `meaning`.
template <class Part>
void describe_choice(Section s, const char* key, std::string& chosen, Names names, std::string meaning,
                     const Parts<Part>& parts) {
  for (const auto& part : parts) {
    names.emplace_back(part->name());
    meaning += "; " + names.back() + ": " + part->meaning();
  }
  s.name(key, chosen, std::move(names), meaning);
}

/// The section of the control methods, whose keys are bound to the drive's setup.
void describe_control(Section s, DriveConfig& c);

/// Sections plant and load; lead_of_drive: as the sensors take it. [ns]
void describe_plant(const Section& root, SimulatedPowerStage::Parameters& plant, LoadConfig& load,
                    const std::int32_t& lead_of_drive);

/// Empty unless a speed is imposed on the motor's shaft while a load turns behind a driveline, or while the
/// shaft begins with a speed of its own, else a sentence.
[[nodiscard]] std::string validate_free_shaft(const SimulatedPowerStage::Parameters& plant,
                                              bool imposes_speed);

}  // namespace sextant
