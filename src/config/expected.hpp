#pragma once

#include <string>

#include "sextant/config/schema.hpp"

namespace sextant {

/// The values that a key may hold, for messages and printed files: "a number from 0.01 to 10".
[[nodiscard]] std::string expected(const FieldKind& kind);

}  // namespace sextant
