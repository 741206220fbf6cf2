#pragma once

#include <cmath>

#include "sextant/core/description.hpp"
#include "sextant/plant/road_load.hpp"

namespace sextant {

/// A vehicle that moves along its road, each of its motors at a wheel, by a gear without loss, without slip:
///   v = r omega_m/i
///   m dv/dt = n i tau/r − m g (c_rr cos α sgn v + sin α) − 1/2 ρ c_d A v|v|
/// It loads and slows every motor alike, see `road_load`.
struct VehicleParameters {
  double mass{0};                ///< m, all of it; 0: there is no vehicle [kg]
  int motors{2};                 ///< n, which share the work evenly [-]
  double wheel_radius{0.3};      ///< r, loaded [m]
  double rolling_coefficient{};  ///< c_rr [-]
  double drag_area{};            ///< c_d A [m²]
  double air_density{1.2};       ///< ρ, at 20 °C and sea level [kg/m³]
  double grade{};                ///< tan α, above zero uphill [-]
  double wheel_inertia{};        ///< of each driven wheel without the rotor in it [kg·m²]
  double standstill_speed{0.1};  ///< below it the rolling resistance fades [m/s]
  double gear_ratio{1};          ///< i, speed of the motor by that of the wheel [-]
  double brake_torque{};         ///< largest one of the friction brake of each driven wheel; 0: none [N·m]

  [[nodiscard]] bool is_given() const noexcept { return mass > 0; }
  /// Way of the vehicle by the angle of a motor, r/i. [m]
  [[nodiscard]] double motor_radius() const noexcept { return wheel_radius / gear_ratio; }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto at_least_zero = [](double x) { return std::isfinite(x) && x >= 0; };
    if (!at_least_zero(mass)) return "the mass must be finite and not below zero";
    if (motors < 1) return "there must be at least one motor";
    if (!(at_least_zero(wheel_radius) && wheel_radius > 0)) return "the wheel radius must be above zero";
    if (!at_least_zero(rolling_coefficient)) return "the rolling coefficient must not be below zero";
    if (!at_least_zero(drag_area)) return "the drag area must not be below zero";
    if (!at_least_zero(air_density)) return "the air density must not be below zero";
    if (!std::isfinite(grade)) return "the grade must be finite";
    if (!at_least_zero(wheel_inertia)) return "the wheel inertia must not be below zero";
    if (!(at_least_zero(standstill_speed) && standstill_speed > 0))
      return "the standstill speed must be above zero";
    if (!(at_least_zero(gear_ratio) && gear_ratio > 0)) return "the gear ratio must be above zero";
    return at_least_zero(brake_torque) ? nullptr : "the torque of the brake must not be below zero";
  }
};

inline void describe(Description& d, VehicleParameters& p) {
  auto& [mass, motors, wheel_radius, rolling_coefficient, drag_area, air_density, grade, wheel_inertia,
         standstill_speed, gear_ratio, brake_torque] = p;
  d.number("mass_kg", mass, {"kg", 0, 1e6, "all of the vehicle; 0: there is none"});
  d.integer("motors", motors, "", 1, 64, "motors that share the work, each at a wheel");
  d.number("wheel_radius_m", wheel_radius, {"m", 0.01, 10, "loaded"});
  d.number("rolling_coefficient", rolling_coefficient, {"", 0, 1, "rolling resistance by weight"});
  d.number("drag_area_m2", drag_area, {"m²", 0, 100, "drag coefficient times frontal area"});
  d.number("air_density_kg_m3", air_density, {"kg/m³", 0, 10, "of the air around it"});
  d.number("grade_percent", {grade, 0.01}, {"%", -100, 100, "rise by run, above zero uphill"});
  d.number("wheel_inertia_kg_m2", wheel_inertia,
           {"kg·m²", 0, 1e4, "of each driven wheel without the rotor in it"});
  d.number("standstill_speed_m_s", standstill_speed,
           {"m/s", 1e-4, 10, "below it the rolling resistance fades to zero"});
  d.number("gear_ratio", gear_ratio,
           {"", 1e-3, 1e3, "speed of each motor by that of its wheel; the gear has no loss"});
  d.number("brake_torque_nm", brake_torque,
           {"N·m", 0, 1e6,
            "largest torque of the friction brake of each driven wheel, by which the driver brakes where "
            "the motor does not, and holds the vehicle at rest; 0: there is none"});
}

inline constexpr double gravity = 9.80665;  ///< g [m/s²]

/// Torque of one motor that holds the vehicle on a grade tan α, r/(i n) m g sin α. [-] → [N·m]
[[nodiscard]] inline double grade_torque(const VehicleParameters& v, double grade) noexcept {
  return v.motor_radius() / v.motors * v.mass * gravity * grade / std::sqrt(1.0 + grade * grade);
}

/// The vehicle as one of its motors feels it.
[[nodiscard]] inline RoadLoad<> road_load(const VehicleParameters& v) noexcept {
  const double radius = v.motor_radius();
  const double share = radius / v.motors;
  const double cosine = 1.0 / std::sqrt(1.0 + v.grade * v.grade);
  return {.quadratic_drag = share * 0.5 * v.air_density * v.drag_area * radius * radius,
          .rolling_torque = share * v.mass * gravity * v.rolling_coefficient * cosine,
          .rolling_speed = v.standstill_speed / radius,
          .grade_torque = grade_torque(v, v.grade),
          .coupled_inertia = share * v.mass * radius + v.wheel_inertia / (v.gear_ratio * v.gear_ratio)};
}

/// Mass that the motors together accelerate when each rotor has this inertia [kg·m²]. [kg]
[[nodiscard]] inline double accelerated_mass(const VehicleParameters& v, double rotor_inertia) noexcept {
  const double radius = v.motor_radius();
  const double wheel = v.wheel_inertia / (v.gear_ratio * v.gear_ratio);
  return v.mass + v.motors * (wheel + rotor_inertia) / (radius * radius);
}

}  // namespace sextant
