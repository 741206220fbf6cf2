#pragma once

#include <cstdint>
#include <cstdio>

#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/command_receiver.hpp"

namespace sextant::ecu {

// What a run of the drive reports at its end, live or in virtual time, for people.

/// What became of the frames under the command's identifier: all of them, by cause.
void print_commands(std::FILE* out, const CommandReceiver& receiver);

/// What crossed the bus. clamped: status frames with a value beyond its signal's range [-].
void print_can(std::FILE* out, const CanBusStats& stats, std::uint64_t clamped);

}  // namespace sextant::ecu
