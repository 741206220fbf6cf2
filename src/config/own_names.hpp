#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sextant {

/// The characters of a key that TOML takes without quotes.
constexpr std::string_view bare_key = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";

/// Adds the name of what a program brings to the names taken. Throws std::invalid_argument where it is no
/// bare key, or taken; kind: as that names it; others: what must not have its name.
inline void take_name(std::vector<std::string>& taken, const std::string& name, const std::string& kind,
                      const std::string& others) {
  const bool is_bare = !name.empty() && name.find_first_not_of(bare_key) == std::string::npos;
  if (!is_bare || std::ranges::find(taken, name) != taken.end()) {
    throw std::invalid_argument("the " + kind + " \"" + name +
                                "\" needs another name, of letters, digits, _ and -, that " + others +
                                " has");
  }
  taken.push_back(name);
}

}  // namespace sextant
