#include <string>

#include "drive_sections.hpp"

namespace sextant {

void describe_torque_monitor(Section s, DriveConfig& c) {
  TorqueMonitor<>::Parameters& p = c.drive.torque_monitor;
  constexpr Range<double> share{0, 0.95};
  constexpr Range<double> deviation_nm{1e-6, 1e9};
  s.flag("enabled", p.enabled, "torque that does not follow the command is a fault");
  s.derived("limit_nm", p.limit, deviation_nm, "N·m", "deviation of the mean torque that is one",
            [&c] { return limits_of(c).torque_deviation; });
  s.number("limit_share", p.limit_share, share, "", "the same as a share of the command; the larger counts");
  s.derived("wrong_sign_nm", p.wrong_sign, deviation_nm, "N·m",
            "mean torque against the command's sign that is a deviation", [&p] { return 0.5 * p.limit; });
  s.time("time_ms", p.time_ns, ns_per_ms, {2, 1e4}, "ms", "longest time for which a deviation lasts");
  s.number("r_s_share", p.r_s_share, share, "", "error of r_s_ohm that must not trip");
  s.number("r_r_share", p.r_r_share, share, "", "error of r_r_ohm that must not trip");
  s.number("l_m_share", p.l_m_share, share, "", "error of l_m_h that must not trip");
  s.number("sensor_share", p.sensor_share, share, "", "error of the torque by the gains of the sensors");
  Section machine = s.section("machine");
  describe(machine, c.monitored_machine, false);
  machine.check([&c]() -> std::string {
    const bool known = c.machine.reactance_frequency_hz || c.monitored_machine.reactance_frequency_hz;
    if (known || !c.monitored_machine.has_reactance()) return {};
    return "reactance_frequency_hz is missing, which the reactances need";
  });
  s.derive([&c, &p] {
    p.machine =
        apply(c.monitored_machine, c.control.machine, c.machine.reactance_frequency_hz.value_or(50.0));
    p.flux_reference = c.control.flux_reference;
    // Of a vector whose phases are off by as much, two of them in the other direction.
    p.current_offset = 4.0 / 3.0 * c.drive.protection.current_offset;
  });
  s.check(p);
}

}  // namespace sextant
