#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace sextant {

/// The shortest decimal that reads back as the same double.
[[nodiscard]] inline std::string number_text(double x) {
  std::array<char, 32> buffer{};
  const double size = std::abs(x);
  const bool plain = x == 0.0 || (size >= 1e-4 && size < 1e7);
  const auto format = plain ? std::chars_format::fixed : std::chars_format::scientific;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), x, format);
  return {buffer.data(), result.ptr};
}

}  // namespace sextant
