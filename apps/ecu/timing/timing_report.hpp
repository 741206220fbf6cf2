#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "ecu/timing/timing_statistics.hpp"

namespace sextant::ecu {

/// Control periods run and missed, and overruns, as a line for people.
void print_periods(std::FILE* out, std::uint64_t periods, std::uint64_t periods_missed,
                   std::uint64_t overruns);

/// The timing of a run as a table for people: wake-ups, execution times, stages, overruns by cause and the
/// worst of them.
void print_timing(std::FILE* out, const TimingStatistics& statistics);

/// A histogram for programs: count, mean, percentiles and maximum [ns], and `buckets` of [middle in ns,
/// count].
[[nodiscard]] nlohmann::json to_json(const LatencyHistogram& histogram);

/// The timing of a run as a JSON file: periods, overruns by cause, and the histograms of wake-up latency,
/// execution time, stages, command to gate, and its part until the receive thread has stored the
/// command. Throws std::runtime_error where the file cannot be written.
void write_timing(const std::string& file, const TimingStatistics& statistics,
                  const LatencyHistogram& hand_over);

}  // namespace sextant::ecu
