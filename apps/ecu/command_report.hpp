#pragma once

#include <cstdio>

#include "sextant/comms/command_receiver.hpp"

namespace sextant::ecu {

/// What became of the frames under the command's identifier, for people: all of them, by cause.
void print_commands(std::FILE* out, const CommandReceiver& receiver);

}  // namespace sextant::ecu
