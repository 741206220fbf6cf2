#pragma once

#include <cstdint>

#include "sextant/config/drive_config.hpp"
#include "sextant/config/machine_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {

/// Transport between drive and plant.
enum class PlantTransport : std::uint8_t { shared_memory, udp };

/// Configuration of a plant in a process of its own.
struct PlantConfig {
  PlantTransport transport{PlantTransport::shared_memory};
  std::int32_t period_ns{100'000};  ///< plant period, as the drive's control period [ns]
  MachineConfig machine{};
  SimulatedPowerStage::Parameters plant{.integrator = IntegratorKind::fixed};
  LoadConfig load{};
  HilParameters hil{.udp_listen = "0.0.0.0:47811", .udp_peer = "127.0.0.1:47810"};
  RealtimeParameters realtime{.wake_every_periods = 1};
};

void describe(Section root, PlantConfig& config);

}  // namespace sextant
