#pragma once

#include <string>

#include "sextant/config/ecu_config.hpp"

namespace sextant::ecu {

/// What Cyclone DDS is started with, and where that comes from.
struct DdsSettings {
  std::string configuration{};  ///< a comma-separated list, of which the later parts have the last word
  std::string source{};         ///< of the part that is not the program's own; empty where there is none
};

/// The configuration of Cyclone DDS: `dds.config_uri` where it is set; otherwise `environment`, the value of
/// CYCLONEDDS_URI (empty: the library's own defaults); where that is not set (null) the loopback interface,
/// as configs/cyclonedds_loopback.xml has it and the scripts take it. In front of it stand defaults for
/// leaving in time: a writer that goes away waits until its readers have acknowledged everything, for 1 s
/// by default, and asks them every 100 ms.
[[nodiscard]] DdsSettings dds_settings(const DdsConfig& config, const char* environment);

}  // namespace sextant::ecu
