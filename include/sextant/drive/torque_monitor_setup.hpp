#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/safety/torque_monitor_limits.hpp"

namespace sextant {

/// What a user may say of `TorqueMonitorLimits`.
template <class T = double>
struct TorqueMonitorSetup {
  bool enabled{TorqueMonitorLimits<T>{}.enabled};
  std::optional<InductionMachineParameters<T>> machine{};  ///< by default that of the basis
  std::optional<T> limit{};                                ///< [N·m]
  T limit_share{TorqueMonitorLimits<T>{}.limit_share};
  std::optional<T> wrong_sign{};  ///< [N·m]
  std::int64_t time_ns{TorqueMonitorLimits<T>{}.time_ns};
  T r_s_share{TorqueMonitorLimits<T>{}.r_s_share};
  T r_r_share{TorqueMonitorLimits<T>{}.r_r_share};
  T l_m_share{TorqueMonitorLimits<T>{}.l_m_share};
  T sensor_share{TorqueMonitorLimits<T>{}.sensor_share};
};

/// All but the machine, which is described as machines are.
template <class T>
void describe(Description& d, TorqueMonitorSetup<T>& setup, const TorqueMonitorLimits<T>& resolved) {
  auto& [enabled, machine, limit, limit_share, wrong_sign, time_ns, r_s_share, r_r_share, l_m_share,
         sensor_share] = setup;
  d.flag("enabled", enabled,
         "whether torque that deviates from the command is TORQUE_PLAUSIBILITY; false: it is estimated and "
         "no fault",
         Changes::always);
  d.derived("limit_nm", limit, resolved.limit,
            {"N·m", 1e-6, 1e9,
             "smallest deviation of the mean torque over 1 ms from the command, beyond the band of the "
             "estimate, that counts; or limit_share, the larger one",
             Changes::always});
  d.number("limit_share", limit_share,
           {"", 0, 0.95, "the same as a share of the command's magnitude", Changes::always});
  d.derived("wrong_sign_nm", wrong_sign, resolved.wrong_sign,
            {"N·m", 1e-6, 1e9,
             "smallest mean torque against the command's sign, beyond the band of the estimate, that "
             "counts",
             Changes::always});
  d.time("time_ms", time_ns,
         in_ms(2, 1e4, "time after which a deviation is a fault at the latest", Changes::always));
  d.number("r_s_share", r_s_share,
           {"", 0, 0.95,
            "largest error of r_s_ohm, as a share of the true value: the larger, the wider the band by "
            "power",
            Changes::when_ready});
  d.number("r_r_share", r_r_share,
           {"", 0, 0.95,
            "largest error of r_r_ohm, as a share of the true value: the larger, the wider the band by "
            "current",
            Changes::when_ready});
  d.number("l_m_share", l_m_share,
           {"", 0, 0.95,
            "largest error of l_m_h, as a share of the true value: the larger, the wider the band by "
            "current",
            Changes::when_ready});
  d.number("sensor_share", sensor_share,
           {"", 0, 0.95,
            "largest error of the estimated torque by the gains of the sensors, as a share of it: widens the "
            "band",
            Changes::always});
}

}  // namespace sextant
