#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/safety/command_limits.hpp"

namespace sextant {

/// What a user may say of `CommandLimits`.
template <class T = double>
struct CommandSetup {
  std::optional<T> torque_limit{};  ///< [N·m]
  T torque_rate{CommandLimits<T>{}.torque_rate};
  std::int64_t timeout_ns{CommandLimits<T>{}.timeout_ns};
  std::int64_t zero_ramp_ns{CommandLimits<T>{}.zero_ramp_ns};
  std::int64_t lost_ns{CommandLimits<T>{}.lost_ns};
  std::int64_t status_timeout_ns{CommandLimits<T>{}.status_timeout_ns};
  std::int64_t status_lost_ns{CommandLimits<T>{}.status_lost_ns};
  std::uint32_t blocked_limit{CommandLimits<T>{}.blocked_limit};
};

template <class T>
void describe(Description& d, CommandSetup<T>& setup, const CommandLimits<T>& resolved) {
  auto& [torque_limit, torque_rate, timeout_ns, zero_ramp_ns, lost_ns, status_timeout_ns, status_lost_ns,
         blocked_limit] = setup;
  d.derived("torque_limit_nm", torque_limit, resolved.torque_limit,
            {"N·m", 1e-3, 1e5, "a command beyond it is blocked", Changes::always});
  d.number("torque_rate_nm_s", torque_rate,
           {"N·m/s", 1e-3, 1e9, "largest rate of the torque reference", Changes::always});
  d.time("timeout_ms", timeout_ns,
         in_ms(1, 1e4, "age at which the torque starts to ramp to zero", Changes::always));
  d.time("zero_ramp_ms", zero_ramp_ns, in_ms(0.01, 1e4, "duration of that ramp", Changes::always));
  d.time("lost_ms", lost_ns, in_ms(1, 1e5, "age at which the command counts as lost", Changes::always));
  d.time("status_timeout_ms", status_timeout_ns,
         in_ms(1, 1e4, "age of the last status frame sent at which the same ramp starts", Changes::always));
  d.time("status_lost_ms", status_lost_ns,
         in_ms(1, 1e5, "age of the last status frame sent that is a fault", Changes::always));
  d.integer("blocked_limit", blocked_limit, "", 1, 1000, "blocked commands in a row that make a fault",
            Changes::always);
}

}  // namespace sextant
