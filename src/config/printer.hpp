#pragma once

#include <string>

#include "sextant/config/schema.hpp"

namespace sextant {

/// Every key of `schema` with its present value, as TOML with comments. `defaults` is the same description of
/// an untouched struct.
[[nodiscard]] std::string print(const Schema& schema, const Schema& defaults);

/// The same values as one JSON object, dotted keys to values; null for an optional key that is not set.
[[nodiscard]] std::string print_json(const Schema& schema);

/// The keys themselves as a JSON list: objects of `key`, `unit`, `meaning` and, where the key has them,
/// `choices`, or `least` and `most`.
[[nodiscard]] std::string print_keys(const Schema& schema);

}  // namespace sextant
