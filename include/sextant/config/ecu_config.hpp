#pragma once

#include <cstdint>
#include <string>

#include "sextant/config/drive_config.hpp"
#include "sextant/config/own_power_stage.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/core/identifier_offset.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {

/// The CAN bus of commands and status.
struct CanConfig {
  std::string bus{"udp_multicast:239.74.163.2:43113"};  ///< backend:interface, or backend:group:port
  IdentifierOffset identifier_offset{};                 ///< of all identifiers and E2E data ids

  [[nodiscard]] const char* validate() const noexcept { return identifier_offset.validate(); }
};

inline void describe(Description& d, CanConfig& p) {
  auto& [bus, offset] = p;
  d.text("bus", bus, "socketcan:<interface> or udp_multicast:<group>:<port>", false);
  d.integer(
      "identifier_offset", offset.value, "", 0, IdentifierOffset::largest,
      "added to all CAN identifiers and E2E data ids, a multiple of 32; distinguishes the drives of one "
      "bus");
}

/// Telemetry over DDS.
struct DdsConfig {
  int domain{0};                   ///< DDS domain [-]
  std::string config_uri{};        ///< file or XML for the middleware; empty: that of the environment
  double telemetry_rate_hz{1000};  ///< of DriveTelemetry [Hz]
  double statistics_rate_hz{1};    ///< of RealTimeStatistics [Hz]
};

inline void describe(Description& d, DdsConfig& p) {
  auto& [domain, uri, telemetry_hz, statistics_hz] = p;
  d.integer("domain", domain, "", 0, 230, "DDS domain");
  d.text("config_uri", uri,
         "Cyclone DDS configuration; empty: CYCLONEDDS_URI decides, without it the loopback interface", true);
  d.number("telemetry_rate_hz", telemetry_hz, {"Hz", 1, 10'000, "rate of DriveTelemetry"});
  d.number("statistics_rate_hz", statistics_hz, {"Hz", 0.01, 100, "rate of RealTimeStatistics"});
}

/// The power stage of the drive's `DriveIo`.
enum class PowerStageKind : std::uint8_t {
  simulated,      ///< a plant in this process
  shared_memory,  ///< a plant in another process of this machine
  udp,            ///< a plant on another machine
  own             ///< one that the program brings
};

/// Configuration of the live drive.
struct EcuConfig {
  int drive_id{1};                       ///< key of the telemetry topics [-]
  std::string power_stage{"simulated"};  ///< name of a `PowerStageKind`, or of one that the program brings
  OwnPowerStages own_power_stages{};     ///< that can be chosen
  DriveConfig drive{};
  HilParameters hil{};
  RealtimeParameters realtime{};
  CanConfig can{};
  DdsConfig dds{};

  [[nodiscard]] PowerStageKind power_stage_kind() const noexcept;
  /// The power stage chosen of those that the program brings. Throws std::logic_error where it is another.
  [[nodiscard]] const OwnPowerStage& own_power_stage() const {
    return named(own_power_stages, power_stage, "power stage");
  }
  /// The time of the power stage is that of the drive: virtual time and several control periods a wake-up.
  [[nodiscard]] bool waits_for_drive() const;
};

void describe(Section root, EcuConfig& config);

}  // namespace sextant
