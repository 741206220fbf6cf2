#pragma once

#include <string>

#include "sextant/config/ecu_config.hpp"

namespace sextant::ecu {

/// The configuration of Cyclone DDS and its source.
struct DdsSettings {
  std::string configuration{};  ///< a comma-separated list; later parts override earlier ones
  std::string source{};         ///< of the part that is not the program's own; empty where there is none
};

/// The configuration of Cyclone DDS: `dds.config_uri` where it is set; otherwise `environment`, the value of
/// CYCLONEDDS_URI (empty: the library's own defaults); where that is not set (null) the loopback interface,
/// as in configs/cyclonedds_loopback.xml, which the scripts use. Defaults for a fast exit precede it: an
/// ending writer waits for acknowledgements of its readers, for 1 s by default, with a request every 100 ms.
[[nodiscard]] DdsSettings dds_settings(const DdsConfig& config, const char* environment);

}  // namespace sextant::ecu
