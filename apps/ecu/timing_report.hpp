#pragma once

#include <cstdio>

#include "ecu/timing_statistics.hpp"

namespace sextant::ecu {

/// The timing of a run as a table for people: wake-ups, work, stages, misses by cause and the worst of them.
void print_timing(std::FILE* out, const TimingStatistics& statistics);

}  // namespace sextant::ecu
