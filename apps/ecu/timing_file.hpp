#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "ecu/timing_statistics.hpp"

namespace sextant::ecu {

/// A histogram for programs: count, mean, percentiles and maximum [ns], and `buckets` of [middle in ns,
/// count].
[[nodiscard]] nlohmann::json to_json(const LatencyHistogram& histogram);

/// The timing of a run as a JSON file: periods, misses by cause, and the histograms of wake-up latency, work,
/// stages, command to gate, and its part until the receive thread has handed the command over. Throws
/// std::runtime_error where the file cannot be written.
void write_timing(const std::string& file, const TimingStatistics& statistics,
                  const LatencyHistogram& hand_over);

}  // namespace sextant::ecu
