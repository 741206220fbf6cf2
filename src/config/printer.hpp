#pragma once

#include <string>

#include "sextant/config/schema.hpp"

namespace sextant {

/// Every key of `schema` with its present value, as TOML with comments. `defaults` is the same description of
/// an untouched struct.
[[nodiscard]] std::string print(const Schema& schema, const Schema& defaults);

}  // namespace sextant
