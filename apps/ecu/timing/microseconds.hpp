#pragma once

#include <cstdint>

namespace sextant::ecu {

/// A time [ns] in microseconds.
[[nodiscard]] constexpr double microseconds(std::int64_t ns) noexcept {
  return double(ns) * 1e-3;
}

}  // namespace sextant::ecu
