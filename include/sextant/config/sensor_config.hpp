#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sextant/config/schema.hpp"
#include "sextant/sim/plant_fault.hpp"
#include "sextant/sim/sensor_model.hpp"
#include "sextant/sim/simulated_drive_io.hpp"

namespace sextant {

/// Keys of [plant.sensors].
/// lead_of_drive: the sampling lead that the drive counts on, the default of theirs. [ns]
void describe(Section s, SensorParameters& p, const std::function<std::int32_t()>& lead_of_drive);

/// Keys of [plant.faults]; u_dc: of the link without a fault [V], read before.
void describe(Section s, PlantFaultParameters& p, const double& u_dc);

/// The kind that is there from power-up on only, as the file names it.
inline constexpr const char* power_up_fault = "cables_swapped";

/// The keys of a fault that a running plant takes, as `print_keys` makes them, without `power_up_fault`.
[[nodiscard]] std::string plant_fault_keys();

/// True where a measurement is the plant's true state, what is commanded acts, and nothing is wrong with the
/// plant.
[[nodiscard]] bool is_ideal(const SimulatedDriveIoParameters& p);

}  // namespace sextant
