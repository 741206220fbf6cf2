#pragma once

#include <cstdint>
#include <string>

#include "sextant/core/description.hpp"

namespace sextant {

/// How the two sides of a link keep time.
enum class Pacing : std::uint8_t {
  real_time,  ///< each side follows its own clock and never waits for the other
  lockstep    ///< virtual time: each side waits for the other, so that a run is the same bit by bit
};

/// The link between a drive and a plant in two processes. Both sides read the same table; each uses its keys.
struct HilParameters {
  std::string link{"sextant"};  ///< name of the shared memory, /dev/shm/<link>
  Pacing pacing{Pacing::real_time};
  int missing_periods{4};  ///< drive: periods without a measurement until it trips [-]
  std::int64_t measurement_timeout_ns{
      10'000'000};  ///< drive: time without a measurement until the plant has timed out [ns]
  std::int64_t pattern_timeout_ns{5'000'000};  ///< plant: time without a pattern until the drive has timed
                                               ///< out; drive: until its patterns are not acknowledged [ns]
  std::int64_t lockstep_timeout_ns{10'000'000'000};  ///< lockstep: longest wait for the other side [ns]
  std::string udp_listen{"0.0.0.0:47810"};           ///< own address and port
  std::string udp_peer{"127.0.0.1:47811"};           ///< where the other side listens

  [[nodiscard]] std::string validate() const {
    if (link.empty() || link.size() > 200 || link.find('/') != std::string::npos || link.front() == '.') {
      return "link must be a name of 1 to 200 characters without \"/\", such as \"sextant\"";
    }
    if (measurement_timeout_ns <= 0 || pattern_timeout_ns <= 0 || lockstep_timeout_ns <= 0) {
      return "the limits of time must be above zero";
    }
    if (missing_periods < 1) return "missing_periods must be 1 or more";
    return {};
  }
};

inline void describe(Description& d, HilParameters& p) {
  auto& [link, pacing, missing, measurement_ns, pattern_ns, lockstep_ns, listen, peer] = p;
  d.text("link", link, "name of the shared memory, the same on both sides", false);
  d.choice("pacing", pacing, {{"real_time", Pacing::real_time}, {"lockstep", Pacing::lockstep}},
           "each side by its own clock, or each waiting for the other in virtual time");
  d.integer("missing_periods", missing, "", 1, 1'000'000,
            "drive: control periods in a row without a measurement until it trips");
  d.time("measurement_timeout_ms", measurement_ns,
         in_ms(0.01, 1e5, "drive: time without a measurement until it trips and the plant has timed out"));
  d.time("pattern_timeout_ms", pattern_ns,
         in_ms(0.01, 1e5,
               "plant: time without a pattern until the drive has timed out and the gates turn off; drive: "
               "time without an acknowledged pattern until it trips"));
  d.time("lockstep_timeout_ms", lockstep_ns,
         in_ms(1, 1e7, "lockstep: longest wait for the other side, in real time"));
  d.text("udp_listen", listen, "own <IPv4 address>:<port>; 0.0.0.0 listens on every address", false);
  d.text("udp_peer", peer, "<IPv4 address>:<port> of the other side", false);
}

}  // namespace sextant
