#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "sextant/config/schema.hpp"
#include "sextant/plant/vehicle_parameters.hpp"
#include "sextant/profiles/driver.hpp"
#include "sextant/profiles/passive_ev_load.hpp"
#include "sextant/profiles/profile.hpp"

namespace sextant {

/// A drive cycle that takes the place of torque profile and load, and what it drives.
struct CycleConfig {
  enum class Load : std::uint8_t { passive_ev, vehicle };
  std::string file{};                        ///< of the cycle; empty: none is given
  ProfileParameters speed{};                 ///< of the vehicle, as that file has it [m/s]
  std::optional<ProfileParameters> grade{};  ///< of the road, where that file has it [-]
  Load load{Load::passive_ev};
  std::string table{};  ///< file that passive_ev.rows are from
  PassiveEvLoad::Parameters passive_ev{};
  VehicleParameters vehicle{};
  Driver::Parameters driver{};  ///< its vehicle is the one above

  [[nodiscard]] bool drives_vehicle() const noexcept { return is_given() && load == Load::vehicle; }

  [[nodiscard]] bool is_given() const noexcept { return !file.empty(); }

  /// Empty when usable or not given, else what is wrong.
  [[nodiscard]] std::string validate() const;
};

/// Sections cycle, vehicle and driver. torque_of_drive: the largest torque that the drive can be asked for,
/// once everything has been read: the driver's limit where none is given [N·m].
void describe(const Section& root, CycleConfig& config, const std::function<double()>& torque_of_drive);

}  // namespace sextant
