#pragma once

#include <span>
#include <string_view>

namespace sextant {

/// A key or table of earlier files, and its replacement; both are dotted paths.
struct MovedKey {
  std::string_view from;
  std::string_view to;
};

/// Every one; the reader's error for `from` names `to`.
[[nodiscard]] std::span<const MovedKey> moved_keys() noexcept;

}  // namespace sextant
