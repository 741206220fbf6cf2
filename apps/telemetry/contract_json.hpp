#pragma once

#include <string>

namespace sextant {

/// Topics and enumerations of the telemetry as one JSON object, by the records that are published:
///   {"enumerations": {NAME: [ENUMERATOR, …]},
///    "topics": {NAME: [{"name", "type", "unit", "text", "key"}, …]}}
/// with members and enumerators in order and the types of configs/interfaces/telemetry.idl. It is what
/// configs/interfaces/telemetry.json holds.
[[nodiscard]] std::string telemetry_contract_json();

}  // namespace sextant
