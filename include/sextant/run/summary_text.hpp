#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "sextant/run/summary.hpp"

namespace sextant {

/// A time of a run. [s]
[[nodiscard]] double in_seconds(std::int64_t t_ns) noexcept;

/// Unit of a metric by its name; empty where there is none of that name.
[[nodiscard]] std::string unit_text(std::string_view metric);

/// `≤ 14`, `≥ 2`, `-3 … 1`, with all of their digits; empty without a bound.
[[nodiscard]] std::string limit_text(const Expectation& expectation);

/// Five digits; `-` for a value that a run did not give.
[[nodiscard]] std::string value_text(double x);

/// `0.2 s to 0.5 s`, `0.2 s to the end`, with all of their digits.
[[nodiscard]] std::string window_text(const TimeWindow& window);

/// Why a run did not pass, where its table of metrics does not show it: its problem, what its verdict comes
/// from, and why its trace ends early. A sentence a line, without a line feed at the end; empty where there
/// is nothing to say.
[[nodiscard]] std::string reason_text(const RunSummary& summary);

}  // namespace sextant
