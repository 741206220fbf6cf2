#pragma once

#include <string>
#include <vector>

#include "sextant/profiles/profile.hpp"

namespace sextant {

/// The points of a profile of shape `table`, from a CSV file with the columns `time_s,value`: times from 0 s
/// on in order, two rows at one time are a jump. Throws std::runtime_error with one sentence that names file,
/// line and column, also where a value is not within `min` and `max` [the profile's unit].
[[nodiscard]] std::vector<ProfilePoint> read_profile_table(const std::string& file, double min, double max);

}  // namespace sextant
