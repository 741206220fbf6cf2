#pragma once

#include <cstdint>
#include <string>

#include "sextant/config/drive_config.hpp"
#include "sextant/config/hil_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/core/identifier_offset.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {

/// The CAN bus of commands and status.
struct CanConfig {
  std::string bus{"udp_multicast:239.74.163.2:43113"};  ///< backend:interface, or backend:group:port
  IdentifierOffset identifier_offset{};                 ///< of all identifiers and E2E data ids
};

/// Telemetry over DDS.
struct DdsConfig {
  int domain{0};                   ///< DDS domain [-]
  std::string config_uri{};        ///< file or XML for the middleware; empty: that of the environment
  double telemetry_rate_hz{1000};  ///< of DriveTelemetry [Hz]
  double statistics_rate_hz{1};    ///< of RealTimeStatistics [Hz]
};

/// The power stage of the drive's `DriveIo`.
enum class PowerStageKind : std::uint8_t {
  simulated,      ///< a plant in this process
  shared_memory,  ///< a plant in another process of this machine
  udp             ///< a plant on another machine
};

/// Configuration of the live drive.
struct EcuConfig {
  int drive_id{1};  ///< key of the telemetry topics [-]
  PowerStageKind power_stage{PowerStageKind::simulated};
  DriveConfig drive{};
  HilParameters hil{};
  RealtimeParameters realtime{};
  CanConfig can{};
  DdsConfig dds{};
};

void describe(Section root, EcuConfig& config);

}  // namespace sextant
