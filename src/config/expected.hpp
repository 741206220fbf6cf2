#pragma once

#include <string>

#include "sextant/config/schema.hpp"

namespace sextant {

/// What a key may hold, as messages and printed files say it: "a number from 0.01 to 10".
[[nodiscard]] std::string expected(const FieldKind& kind);

}  // namespace sextant
