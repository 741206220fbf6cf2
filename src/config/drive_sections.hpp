#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sextant/config/drive_config.hpp"

namespace sextant {

/// The largest magnitude that a profile reaches in a run of that length; the profile must be valid.
[[nodiscard]] double largest_magnitude(const ProfileParameters& profile, std::int64_t duration_ns);

/// The section of the control methods, whose keys are bound to the drive's setup.
void describe_control(Section s, DriveConfig& c);

/// The keys of a machine that differs from `machine` in what they set; `unset`: what counts for the others;
/// `circuit`: of which circuit they are unless they say so.
void describe_other_machine(Section section, MachineConfig& other, const MachineConfig& machine,
                            const std::string& unset, const std::function<MachineCircuit()>& circuit);

/// The check of the plant's machine; saturation and iron loss are checked where they are described.
void check_plant(Section machine, const DrivePlantParameters<double>& p);

}  // namespace sextant
