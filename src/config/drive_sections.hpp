#pragma once

#include <cstdint>
#include <string>

#include "common_ranges.hpp"
#include "sextant/config/drive_config.hpp"
#include "sextant/drive/drive_limits.hpp"

namespace sextant {

/// Default limits from machine, flux reference and link; to be called when these have been read.
[[nodiscard]] inline DriveLimits<> limits_of(const DriveConfig& c) {
  return drive_limits(c.control.machine, c.control.flux_reference, c.plant.io.u_dc);
}

/// The largest magnitude that a profile reaches in a run of that length; the profile must be valid.
[[nodiscard]] double largest_magnitude(const ProfileParameters& profile, std::int64_t duration_ns);

/// Sections of a drive, each of which needs others for its default values.
void describe_control(Section s, DriveConfig& c);
void describe_command(Section s, DriveConfig& c);
void describe_capability(Section s, DriveConfig& c);
void describe_protection(Section s, DriveConfig& c);
void describe_torque_monitor(Section s, DriveConfig& c);

/// The keys of a machine that differs from `machine` in what they set; `unset`: what counts for the others.
void describe_other_machine(Section section, MachineConfig& other, const MachineConfig& machine,
                            const std::string& unset);

}  // namespace sextant
