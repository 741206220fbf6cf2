#include "sextant/config/ecu_config.hpp"

#include <string>

namespace sextant {
namespace {

void describe(Section s, RealtimeParameters& p) {
  s.integer("wake_every_periods", p.wake_every_periods, {1, 10'000}, "",
            "control periods run at each wake-up");
  s.flag("required", p.required, "refuse to start without the rights to real time");
  s.integer("priority", p.priority, {1, 98}, "", "SCHED_FIFO priority of the control thread");
  s.integer("cpu", p.cpu, {-1, 1023}, "", "CPU that the control thread is bound to, -1 for any");
  s.flag("lock_memory", p.lock_memory, "keep all memory resident");
  s.time("watchdog_ms", p.watchdog_ns, 1e6, {1, 1e5}, "ms",
         "without a wake-up for so long the gates are opened");
  s.check(p);
}

void describe(Section s, CanConfig& p) {
  s.text("bus", p.bus, "socketcan:<interface> or udp_multicast:<group>:<port>");
}

void describe(Section s, DdsConfig& p) {
  s.integer("domain", p.domain, {0, 230}, "", "DDS domain");
  s.text("config_uri", p.config_uri, "Cyclone DDS configuration; empty: CYCLONEDDS_URI decides", true);
  s.number("telemetry_rate_hz", p.telemetry_rate_hz, {1, 10'000}, "Hz", "rate of DriveTelemetry");
  s.number("statistics_rate_hz", p.statistics_rate_hz, {0.01, 100}, "Hz", "rate of RealTimeStatistics");
}

/// What the wake-ups of the control thread have to be shorter than.
std::string check_wake_period(const EcuConfig& c) {
  const std::int64_t wake_ns = std::int64_t{c.realtime.wake_every_periods} * c.drive.drive.period_ns;
  if (c.realtime.watchdog_ns < 2 * wake_ns) {
    return "watchdog_ms is too short: it must be at least twice wake_every_periods control periods";
  }
  if (c.drive.drive.gate.timeout_ns <= wake_ns) {
    return "wake_every_periods is too large: so many control periods take longer than gate.timeout_ms";
  }
  return {};
}

}  // namespace

void describe(Section root, EcuConfig& c) {
  root.integer("drive_id", c.drive_id, {0, 65'535}, "", "tells drives apart that share a DDS domain");
  describe(root, c.drive);
  Section realtime = root.section("realtime");
  describe(realtime, c.realtime);
  realtime.check([&c] { return check_wake_period(c); });
  describe(root.section("can"), c.can);
  describe(root.section("dds"), c.dds);
}

}  // namespace sextant
