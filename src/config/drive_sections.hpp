#pragma once

#include <cstdint>
#include <string>

#include "common_ranges.hpp"
#include "sextant/config/drive_config.hpp"

namespace sextant {

/// The largest magnitude that a profile reaches in a run of that length; the profile must be valid.
[[nodiscard]] double largest_magnitude(const ProfileParameters& profile, std::int64_t duration_ns);

/// Sections of a drive, whose keys are bound to its setup.
void describe_control(Section s, DriveConfig& c);
void describe_command(Section s, DriveConfig& c);
void describe_capability(Section s, DriveConfig& c);
void describe_protection(Section s, DriveConfig& c);
void describe_torque_monitor(Section s, DriveConfig& c);

/// The keys of a machine that differs from `machine` in what they set; `unset`: what counts for the others.
void describe_other_machine(Section section, MachineConfig& other, const MachineConfig& machine,
                            const std::string& unset);

}  // namespace sextant
