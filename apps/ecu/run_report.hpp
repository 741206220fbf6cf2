#pragma once

#include <cstdint>
#include <cstdio>

#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/command_receiver.hpp"

namespace sextant::ecu {

// The report at the end of a run, live or in virtual time, for people.

/// The frames under the command's identifier: accepted, and rejected by cause.
void print_commands(std::FILE* out, const CommandReceiver& receiver);

/// Counts of the bus. clamped: status frames with a value beyond its signal's range [-].
void print_can(std::FILE* out, const CanBusStats& stats, std::uint64_t clamped);

}  // namespace sextant::ecu
