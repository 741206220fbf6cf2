#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sextant/config/ecu_config.hpp"
#include "sextant/config/schema.hpp"

namespace sextant {

/// What the fault of a drive means for the other drives of its process.
enum class OnFault : std::uint8_t {
  others_go_on,   ///< nothing
  all_shut_down,  ///< every drive ramps its torque to zero and shuts down, and the run ends
};

/// The drives of one process.
struct DrivesConfig {
  static constexpr std::size_t most = 8;  ///< drives [-]

  OnFault on_fault{OnFault::others_go_on};
  std::vector<EcuConfig> drives{};  ///< at least one, all on one bus and in one DDS domain

  /// File or socket of a drive: the name itself where there is one drive, else with the drive's id behind the
  /// stem (run.h5: run_2.h5). Empty for an empty name.
  [[nodiscard]] std::string file_of(const std::string& name, std::size_t drive) const;
};

void describe(Section root, DrivesConfig& config);

/// What of the last drive excludes those before it, in one sentence that names the key; empty where nothing
/// does.
[[nodiscard]] std::string check_last_drive(const DrivesConfig& config);

}  // namespace sextant
