#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "sextant/config/ecu_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/drive/drive.hpp"

namespace sextant::ecu {

/// The drive of a configuration, with its controller.
class ConfiguredDrive {
 public:
  explicit ConfiguredDrive(const DriveConfig& config)
      : controller_{make_controller(config)}, drive_{config.drive, *controller_} {}
  ConfiguredDrive(const ConfiguredDrive&) = delete;
  ConfiguredDrive& operator=(const ConfiguredDrive&) = delete;

  [[nodiscard]] Drive<double>& drive() noexcept { return drive_; }
  [[nodiscard]] const Controller<double>& controller() const noexcept { return *controller_; }

 private:
  std::unique_ptr<Controller<double>> controller_;
  Drive<double> drive_;
};

/// Control periods in one telemetry sample of the configured rate, at least one. [-]
[[nodiscard]] inline std::uint32_t periods_per_sample(const EcuConfig& config) {
  const double wanted = 1e9 / (config.dds.telemetry_rate_hz * config.drive.drive.period_ns);
  return std::uint32_t(std::max(1L, std::lround(wanted)));
}

}  // namespace sextant::ecu
