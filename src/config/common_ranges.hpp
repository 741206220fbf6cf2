#pragma once

#include "sextant/config/schema.hpp"

namespace sextant {

inline constexpr double ns_per_us = 1e3;
inline constexpr double ns_per_ms = 1e6;
inline constexpr double ns_per_s = 1e9;

/// Ranges of quantities that several sections describe.
inline constexpr Range<double> torque_magnitude_nm{1e-3, 1e5};
inline constexpr Range<double> current_a{0.1, 1e5};
inline constexpr Range<double> link_voltage_v{1, 2e4};

}  // namespace sextant
