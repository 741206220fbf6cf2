#include "sextant/config/hil_config.hpp"

namespace sextant {

void describe(Section s, HilParameters& p) {
  s.text("link", p.link, "name of the shared memory, the same on both sides");
  s.choice("pacing", p.pacing, {{"real_time", Pacing::real_time}, {"lockstep", Pacing::lockstep}},
           "each side by its own clock, or each waiting for the other in virtual time");
  s.integer("missing_periods", p.missing_periods, {1, 1'000'000}, "",
            "drive: so many control periods in a row without a measurement and it trips");
  s.time("measurement_timeout_ms", p.measurement_timeout_ns, 1e6, {0.01, 1e5}, "ms",
         "drive: without a measurement for so long it trips, and the plant counts as timed out");
  s.time(
      "pattern_timeout_ms", p.pattern_timeout_ns, 1e6, {0.01, 1e5}, "ms",
      "plant: without a pattern for so long the drive counts as dead and the gates are opened; drive: when "
      "the plant takes no pattern for so long it trips");
  s.time("lockstep_timeout_ms", p.lockstep_timeout_ns, 1e6, {1, 1e7}, "ms",
         "lockstep: longest wait for the other side, by the clock on the wall");
  s.text("udp_listen", p.udp_listen, "own <IPv4 address>:<port>; 0.0.0.0 listens on every address");
  s.text("udp_peer", p.udp_peer, "<IPv4 address>:<port> of the other side");
  s.check(p);
}

}  // namespace sextant
