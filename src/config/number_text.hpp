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

/// Four significant digits, for a value in a message that was computed and not typed.
[[nodiscard]] inline std::string rounded_text(double x) {
  if (x == 0.0 || !std::isfinite(x)) return number_text(x);
  const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(std::abs(x))));
  return number_text(std::round(x * scale) / scale);
}

}  // namespace sextant
