#pragma once

#include <string>

#include "sextant/sim/summary.hpp"

namespace sextant {

/// `≤ 14`, `≥ 2`, `-3 … 1`; empty without a bound.
[[nodiscard]] std::string limit_text(const Expectation& expectation);

/// Five digits; `-` for a value that a run did not give.
[[nodiscard]] std::string value_text(double x);

/// `0.2 s to 0.5 s`, `0.2 s to the end`.
[[nodiscard]] std::string window_text(const TimeWindow& window);

/// Why a run did not pass, where its table of metrics does not show it: a sentence a line, without a line
/// feed at the end; empty where there is nothing to say.
[[nodiscard]] std::string reason_text(const RunSummary& summary);

}  // namespace sextant
