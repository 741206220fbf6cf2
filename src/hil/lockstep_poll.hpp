#pragma once

#include <cstdint>

namespace sextant {

/// Between two looks of a waiting side of a lockstep link whether the other one still holds it. [ns]
inline constexpr std::int64_t lockstep_poll_ns = 20'000'000;

}  // namespace sextant
