#include "sextant/config/cycle_config.hpp"

#include <utility>

#include "sextant/profiles/drive_cycle.hpp"

namespace sextant {
namespace {

void describe_cycle(Section s, CycleConfig& p) {
  s.file(
      "file", p.file,
      "time_s and speed_mph, speed_kmh or speed_m_s, and grade or grade_percent of a road that is not level",
      "drive cycle, which takes the place of profile.torque_nm and load", [&p](const std::string& path) {
        DriveCycle cycle = read_drive_cycle(path);
        p.speed = std::move(cycle.speed);
        p.grade = std::move(cycle.grade);
      });
  s.choice(
      "load", p.load,
      {{"passive_ev", CycleConfig::Load::passive_ev}, {"vehicle", CycleConfig::Load::vehicle}},
      "torque reference and imposed wheel speed looked up by vehicle speed; or a vehicle and its driver");
  s.file("table", p.table, "torque_nm,vehicle_speed_kmh,wheel_speed_rpm",
         "steady states that the passive EV load looks up",
         [&p](const std::string& path) { p.passive_ev.rows = read_passive_ev_table(path); });
  s.choice("extrapolation", p.passive_ev.extrapolation,
           {{"linear", PassiveEvLoad::Extrapolation::linear},
            {"clip", PassiveEvLoad::Extrapolation::clip},
            {"origin", PassiveEvLoad::Extrapolation::origin}},
           "torque beyond the table: its outer lines go on; its outer values hold; or from the origin to its "
           "first row");
  s.check(p);
}

void describe(Section s, Driver::Parameters& p, const std::function<double()>& torque_of_drive) {
  s.time("period_ms", p.period_ns, in_ms(0.01, 1e4, "between two decisions of the driver"));
  s.number("bandwidth_rad_s", p.bandwidth, {"rad/s", 1e-3, 1e3, "of the speed loop"});
  s.number("integral_time_s", p.integral_time, {"s", 1e-3, 1e4, "of the speed loop"});
  s.defaulted_by("torque_limit_nm", p.torque_limit,
                 [&p, torque_of_drive] { p.torque_limit = torque_of_drive(); },
                 {"N·m", 1e-3, 1e5, "of each motor, driving and braking"});
  s.number("regeneration_from_m_s", p.regeneration_from,
           {"m/s", 0, 100,
            "vehicle speed from which on the motors brake with all that they can; below it with a share that "
            "falls to zero at rest, and vehicle.brake_torque_nm does the rest, without which it has no "
            "effect"});
  s.check(p);
}

}  // namespace

std::string CycleConfig::validate() const {
  if (!is_given()) {
    if (!table.empty()) return "table is given, but the cycle's file is missing";
    if (vehicle.is_given()) return "a vehicle is given, but no cycle that it follows";
    return load == Load::vehicle ? "load is given, but the cycle's file is missing" : "";
  }
  if (load == Load::vehicle) {
    if (!table.empty()) return "table is given, but load is \"vehicle\"";
    if (grade && vehicle.grade != 0.0)
      return "the cycle's file has a grade, and vehicle.grade_percent is given";
    return vehicle.is_given() ? "" : "load \"vehicle\" needs a vehicle: vehicle = \"FILE\"";
  }
  if (vehicle.is_given()) return "a vehicle is given, but load is \"passive_ev\"";
  if (grade)
    return "the cycle's file has a grade, which load \"passive_ev\" cannot follow: its table is of one road";
  if (table.empty()) return "load \"passive_ev\" needs a table";
  return passive_ev.validate();
}

void describe(const Section& root, CycleConfig& p, const std::function<double()>& torque_of_drive) {
  describe_cycle(root.section("cycle"), p);
  describe_parameters(root.section_or_file("vehicle"), p.vehicle);
  describe(root.section("driver"), p.driver, torque_of_drive);
}

}  // namespace sextant
