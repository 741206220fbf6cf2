#pragma once

#include <algorithm>
#include <string>

namespace sextant {

/// A key that TOML takes without quotes.
[[nodiscard]] inline bool is_bare_key(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

}  // namespace sextant
