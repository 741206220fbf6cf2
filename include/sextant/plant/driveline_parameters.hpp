#pragma once

#include <cmath>

#include "sextant/core/description.hpp"

namespace sextant {

/// A load with an inertia of its own behind a shaft that twists, behind a gear. None by default: the load is
/// on the motor's shaft. All but the ratio is of the load's side of the gear.
template <class T = double>
struct DrivelineParameters {
  T inertia{};      ///< J_2 of the load; 0: there is no driveline, and nothing else counts [kg·m²]
  T stiffness{};    ///< c of the shaft, torque by twist [N·m/rad]
  T damping{};      ///< d of the shaft, torque by the rate of the twist [N·m·s/rad]
  T backlash{};     ///< full gap, from one contact to the other [rad]
  T gear_ratio{1};  ///< n, speed of the motor by that of the load [-]

  friend constexpr bool operator==(const DrivelineParameters&, const DrivelineParameters&) noexcept = default;

  /// True where the load turns on its own.
  [[nodiscard]] constexpr bool acts() const noexcept { return inertia > T(0); }

  /// The same behind a ratio of 1, as the motor's shaft has it: inertia, stiffness and damping by n², angles
  /// times n. Torques of the load then count by n, and speeds times n.
  [[nodiscard]] constexpr DrivelineParameters referred() const noexcept {
    const T square = gear_ratio * gear_ratio;
    return {inertia / square, stiffness / square, damping / square, backlash * gear_ratio, T(1)};
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    for (const T x : {inertia, stiffness, damping, backlash}) {
      if (!(std::isfinite(x) && x >= T(0)))
        return "inertia, stiffness, damping and backlash of the driveline must be finite and not below zero";
    }
    if (!(std::isfinite(gear_ratio) && gear_ratio > T(0)))
      return "the gear ratio of the driveline must be above zero";
    if (!acts()) {
      return *this == DrivelineParameters{}
                 ? nullptr
                 : "stiffness, damping, backlash and gear ratio need a driveline with an inertia above zero";
    }
    return stiffness > T(0) ? nullptr : "the stiffness must be above zero where the driveline has an inertia";
  }
};

template <class T>
void describe(Description& d, DrivelineParameters<T>& p) {
  auto& [inertia, stiffness, damping, backlash, gear_ratio] = p;
  d.number("inertia_kg_m2", inertia,
           {"kg·m²", 0, 1e6,
            "of the load behind a shaft that twists, on which the load torque and a vehicle's road load and "
            "mass then act in place of the motor's shaft; this table is of the load's side of the gear; "
            "integrators stop at each switching, and exact is fixed; 0: the load is on the motor's shaft"});
  d.number("stiffness_nm_rad", stiffness,
           {"N·m/rad", 0, 1e9, "of the shaft, torque by its twist; above 0 where inertia_kg_m2 is not 0"});
  d.number("damping_nm_s_rad", damping,
           {"N·m·s/rad", 0, 1e6, "of the shaft, torque by the rate of its twist"});
  d.number(
      "backlash_rad", backlash,
      {"rad", 0, 10, "full gap from one contact of the shaft to the other; a contact only pushes; 0: none"});
  d.number("gear_ratio", gear_ratio,
           {"", 1e-3, 1e3,
            "speed of the motor by that of the load: at the motor inertia, stiffness and damping count by "
            "its square, the load torque by it, and angles times it"});
}

}  // namespace sextant
