#include "drive_sections.hpp"

namespace sextant {

void describe_torque_monitor(Section s, DriveConfig& c) {
  TorqueMonitorSetup<>& p = c.setup.torque_monitor;
  const TorqueMonitorLimits<>& resolved = c.drive.torque_monitor;
  constexpr Range<double> share{0, 0.95};
  constexpr Range<double> deviation_nm{1e-6, 1e9};
  s.flag("enabled", p.enabled,
         "whether torque that deviates from the command is TORQUE_PLAUSIBILITY; false: it is estimated and "
         "no fault");
  s.derived("limit_nm", p.limit, resolved.limit, deviation_nm, "N·m",
            "smallest deviation of the mean torque over 1 ms from the command, beyond the band of the "
            "estimate, that counts; or limit_share, the larger one");
  s.number("limit_share", p.limit_share, share, "", "the same as a share of the command's magnitude");
  s.derived("wrong_sign_nm", p.wrong_sign, resolved.wrong_sign, deviation_nm, "N·m",
            "smallest mean torque against the command's sign, beyond the band of the estimate, that counts");
  s.time("time_ms", p.time_ns, ns_per_ms, {2, 1e4}, "ms",
         "time after which a deviation is a fault at the latest");
  s.number("r_s_share", p.r_s_share, share, "",
           "largest error of r_s_ohm, as a share of the true value: the larger, the wider the band by power");
  s.number(
      "r_r_share", p.r_r_share, share, "",
      "largest error of r_r_ohm, as a share of the true value: the larger, the wider the band by current");
  s.number("l_m_share", p.l_m_share, share, "",
           "largest error of l_m_h, as a share of the true value: the larger, the wider the band by current");
  s.number(
      "sensor_share", p.sensor_share, share, "",
      "largest error of the estimated torque by the gains of the sensors, as a share of it: widens the band");
  describe_other_machine(s.section("machine"), c.monitored_machine, c.machine, "that of the controller");
  s.check(resolved);
}

}  // namespace sextant
