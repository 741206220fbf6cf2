#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/command_receiver.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/core/identifier_offset.hpp"

namespace sextant::ecu {

// The report at the end of a run, live or in virtual time, for people.

/// The frames under the command's identifier: accepted, and rejected by cause; where there was none, the
/// identifier. offset: the receiver's.
void print_commands(std::FILE* out, const CommandReceiver& receiver, IdentifierOffset offset);

/// Why a run ended in FAULT, in one sentence. source: the file that the drive followed; empty where it had
/// none.
[[nodiscard]] std::string tripped_text(Fault first, const std::string& source);

/// Counts of the bus. clamped: status frames with a value beyond its signal's range [-].
void print_can(std::FILE* out, const CanBusStats& stats, std::uint64_t clamped);

}  // namespace sextant::ecu
