#include "sextant/config/hil_config.hpp"

namespace sextant {

void describe(Section s, HilParameters& p) {
  s.text("link", p.link, "name of the shared memory, the same on both sides");
  s.choice("pacing", p.pacing, {{"real_time", Pacing::real_time}, {"lockstep", Pacing::lockstep}},
           "each side by its own clock, or each waiting for the other in virtual time");
  s.integer("missing_periods", p.missing_periods, {1, 1'000'000}, "",
            "drive: control periods in a row without a measurement until it trips");
  s.time("measurement_timeout_ms", p.measurement_timeout_ns, 1e6, {0.01, 1e5}, "ms",
         "drive: time without a measurement until it trips and the plant has timed out");
  s.time("pattern_timeout_ms", p.pattern_timeout_ns, 1e6, {0.01, 1e5}, "ms",
         "plant: time without a pattern until the drive has timed out and the gates turn off; drive: time "
         "without "
         "an acknowledged pattern until it trips");
  s.time("lockstep_timeout_ms", p.lockstep_timeout_ns, 1e6, {1, 1e7}, "ms",
         "lockstep: longest wait for the other side, in real time");
  s.text("udp_listen", p.udp_listen, "own <IPv4 address>:<port>; 0.0.0.0 listens on every address");
  s.text("udp_peer", p.udp_peer, "<IPv4 address>:<port> of the other side");
  s.check(p);
}

}  // namespace sextant
