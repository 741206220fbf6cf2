#pragma once

#include <string>

#include "sextant/config/schema.hpp"

namespace sextant {

/// Every key of `schema` with its present value, as TOML with comments. `defaults` is the same description of
/// an untouched struct.
[[nodiscard]] std::string print(const Schema& schema, const Schema& defaults);

/// The same values as one JSON object, dotted keys to values; null for an optional key that is not set.
[[nodiscard]] std::string print_json(const Schema& schema);

/// The value of a key as TOML; empty for an optional one that is not set.
[[nodiscard]] std::string value_text(const Field& field);

/// The keys with their present values and when they may change as a JSON list: as `print_keys`, and `changes`
/// and `value`, which is null for an optional key that is not set.
[[nodiscard]] std::string print_running(const Schema& schema);

/// The schema with the items that its lists have now.
[[nodiscard]] Schema expanded(const Schema& schema);

/// The keys themselves as a JSON list: objects of `key`, `unit`, `meaning` and, where the key has them,
/// `choices`, or `least` and `most`.
[[nodiscard]] std::string print_keys(const Schema& schema);

}  // namespace sextant
