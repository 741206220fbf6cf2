#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sextant/config/drive_override.hpp"

namespace sextant::ecu {

/// A change of a key of running drives at an instant of virtual time.
struct TimedOverride {
  std::int64_t t_ns{};  ///< [ns]
  DriveOverride given{};
};

/// Of `TIME:KEY=VALUE` and `TIME:drive[ID].KEY=VALUE`, TIME in seconds. Throws std::runtime_error with a
/// sentence.
[[nodiscard]] std::vector<TimedOverride> timed_overrides(const std::vector<std::string>& at);

}  // namespace sextant::ecu
