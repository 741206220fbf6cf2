#pragma once

#include <cstdint>
#include <cstdio>

#include <fmt/format.h>

#include "sextant/hil/datagram_reception.hpp"

namespace sextant {

/// Prints one side's counts of a link by UDP. unsent: datagrams that the kernel did not send. [-]
inline void print_network(std::FILE* out, const DatagramReception::Counters& c, std::uint64_t unsent) {
  fmt::print(out, "datagrams {} received, {} lost, {} reordered, {} repeated, {} late; {} not sent\n",
             c.received, c.lost, c.reordered, c.repeated, c.late, unsent);
  if (c.foreign + c.other_version + c.other_period > 0) {
    fmt::print(out, "  dropped: {} foreign, {} of another version, {} with another period\n", c.foreign,
               c.other_version, c.other_period);
  }
}

}  // namespace sextant
