#pragma once

#include <cmath>
#include <cstdint>

namespace sextant {

/// Limits of a vehicle's commands.
template <class T = double>
struct CommandLimits {
  T torque_limit{T(150)};                 ///< largest magnitude of a request [N·m]
  T torque_rate{T(1e6)};                  ///< largest rate of the torque reference [N·m/s]
  std::int64_t timeout_ns{40'000'000};    ///< age at which the torque reference starts to ramp to zero [ns]
  std::int64_t zero_ramp_ns{10'000'000};  ///< duration of that ramp, from any torque [ns]
  std::int64_t lost_ns{200'000'000};      ///< age at which the command counts as lost [ns]
  std::int64_t status_timeout_ns{
      80'000'000};                           ///< age of the last status frame at which that ramp starts [ns]
  std::int64_t status_lost_ns{300'000'000};  ///< age of the last status frame that is a fault [ns]
  std::uint32_t blocked_limit{3};            ///< blocked frames in a row that make a fault [-]

  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(torque_limit) && torque_limit > T(0))) return "the torque limit must be above zero";
    if (!(std::isfinite(torque_rate) && torque_rate > T(0))) return "the torque rate must be above zero";
    if (timeout_ns <= 0) return "the command timeout must be above zero";
    if (zero_ramp_ns <= 0) return "the ramp to zero must take longer than zero";
    if (lost_ns < timeout_ns) return "a command cannot be lost before it has timed out";
    if (status_timeout_ns <= 0) return "the status timeout must be above zero";
    if (status_lost_ns < status_timeout_ns) return "status cannot be lost before it has timed out";
    if (blocked_limit == 0) return "at least one blocked frame makes a fault";
    return nullptr;
  }
};

}  // namespace sextant
