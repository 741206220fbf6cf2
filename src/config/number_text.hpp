#pragma once

#include <array>
#include <charconv>
#include <string>

namespace sextant {

/// The shortest decimal that reads back as the same double.
[[nodiscard]] inline std::string number_text(double x) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), x);
  return {buffer.data(), result.ptr};
}

}  // namespace sextant
