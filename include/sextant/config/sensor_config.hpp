#pragma once

#include <string>

#include "sextant/config/schema.hpp"
#include "sextant/power_stage/simulated_drive_io.hpp"

namespace sextant {

/// The keys of a fault that a running plant takes, as `print_keys` makes them, without `power_up_fault`.
[[nodiscard]] std::string plant_fault_keys();

/// The fault of a request: a line `key=value` for each key of [plant.faults] that it gives; the others are
/// those of `configured`. Values are as after --set. Throws ConfigError.
[[nodiscard]] PlantFaultParameters requested_fault(const std::string& request,
                                                   const PlantFaultParameters& configured);

/// True where a measurement is the plant's true state, what is commanded acts, and nothing is wrong with the
/// plant.
[[nodiscard]] bool is_ideal(const SimulatedDriveIoParameters& p);

}  // namespace sextant
