#pragma once

#include <cstdint>
#include <string>

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

}  // namespace sextant
