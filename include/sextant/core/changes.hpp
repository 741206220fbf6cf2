#pragma once

#include <cstdint>

namespace sextant {

/// When a parameter may change while the drive runs, the latest first.
enum class Changes : std::uint8_t {
  never,       ///< with a new start alone
  when_ready,  ///< with the gates off and the machine without flux (`Drive::is_at_rest`)
  always       ///< between any two control periods
};

[[nodiscard]] constexpr const char* to_string(Changes c) noexcept {
  switch (c) {
    case Changes::never:
      return "never";
    case Changes::when_ready:
      return "when_ready";
    case Changes::always:
      return "always";
  }
  return "?";
}

}  // namespace sextant
