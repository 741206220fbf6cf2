#pragma once

#include "sextant/config/ecu_extensions.hpp"

namespace sextant {

/// The whole of `sextant-ecu`: its command line, configuration, drives, threads, CAN and telemetry, and
/// virtual time. `own`: control methods and power stages beside Sextant's, which a configuration chooses by
/// name like any other. `sextant-telemetry` is looked for beside the running program, then on PATH. Messages
/// begin with the file name of argv[0]. Returns the exit status.
///
///   int main(int argc, char** argv) {
///     return sextant::ecu_program(argc, argv, {.power_stages = {sextant::own_power_stage<MyInverter>()}});
///   }
[[nodiscard]] int ecu_program(int argc, char** argv, const EcuExtensions& own = {});

}  // namespace sextant
