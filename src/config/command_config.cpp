#include <cmath>
#include <optional>

#include "drive_sections.hpp"

namespace sextant {
namespace {

/// An optional speed of the configured curve.
void curve_speed(Section& s, const char* key, double& member, const char* meaning) {
  s.add(key, "rad/s", meaning,
        NumberField{{1e-3, 1e4},
                    [&member] { return std::isfinite(member) ? std::optional{member} : std::nullopt; },
                    [&member](double x) { member = x; }});
}

}  // namespace

void describe_command(Section s, DriveConfig& c) {
  CommandSetup<>& p = c.setup.command;
  s.derived("torque_limit_nm", p.torque_limit, c.drive.command.torque_limit, torque_magnitude_nm, "N·m",
            "a command beyond it is blocked");
  s.number("torque_rate_nm_s", p.torque_rate, {1e-3, 1e9}, "N·m/s", "largest rate of the torque reference");
  s.time("timeout_ms", p.timeout_ns, ns_per_ms, {1, 1e4}, "ms",
         "age at which the torque starts to ramp to zero");
  s.time("zero_ramp_ms", p.zero_ramp_ns, ns_per_ms, {0.01, 1e4}, "ms", "duration of that ramp");
  s.time("lost_ms", p.lost_ns, ns_per_ms, {1, 1e5}, "ms", "age at which the command counts as lost");
  s.time("status_timeout_ms", p.status_timeout_ns, ns_per_ms, {1, 1e4}, "ms",
         "age of the last status frame sent at which the same ramp starts");
  s.time("status_lost_ms", p.status_lost_ns, ns_per_ms, {1, 1e5}, "ms",
         "age of the last status frame sent that is a fault");
  s.integer("blocked_limit", p.blocked_limit, {1, 1000}, "", "blocked commands in a row that make a fault");
  s.check(c.drive.command);
}

void describe_capability(Section s, DriveConfig& c) {
  CapabilitySetup<>& p = c.setup.capability;
  s.derived("torque_nm", p.torque, c.drive.capability.torque, torque_magnitude_nm, "N·m",
            "largest available torque");
  s.number("voltage_use", p.voltage_use, {0.1, 1}, "", "share of u_dc/sqrt(3) that a torque may need");
  s.number("breakdown_use", p.breakdown_use, {0.1, 1}, "",
           "share of the breakdown torque, at the flux that the voltage allows, that may be used");
  curve_speed(s, "base_speed_rad_s", p.base_speed,
              "from it on the motoring torque falls linearly; not set: no such curve");
  curve_speed(s, "zero_torque_speed_rad_s", p.zero_torque_speed,
              "from it on there is no motoring torque; not set: no such curve");
  s.check(c.drive.capability);
}

}  // namespace sextant
