#pragma once

#include <cstdint>

#include "sextant/run/scenario.hpp"

namespace sextant {

/// Marks what a drive plays of a scenario without a driven cycle, torque reference and duration: two programs
/// that play the same have the same mark, others have another one, but for one in 2^32. Never 0.
///
/// 32-bit FNV-1a of the members' bytes (RFC 9923).
[[nodiscard]] std::uint32_t scenario_mark(const Scenario& scenario) noexcept;

}  // namespace sextant
