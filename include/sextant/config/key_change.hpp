#pragma once

#include <string>
#include <vector>

#include "sextant/config/ecu_config.hpp"
#include "sextant/core/changes.hpp"

namespace sextant {

/// A key that has another value in one configuration than in another.
struct KeyChange {
  std::string key{};
  Changes changes{Changes::never};
  std::string from{};  ///< as TOML; empty where it is not set
  std::string to{};    ///< the same
};

/// What differs, values that follow from others included, in the order of the description. Both have the same
/// control methods. Of a list of another length the list counts as one key.
[[nodiscard]] std::vector<KeyChange> key_changes(const EcuConfig& before, const EcuConfig& after);

}  // namespace sextant
