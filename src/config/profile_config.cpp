#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "drive_sections.hpp"
#include "sextant/config/drive_config.hpp"
#include "sextant/profiles/profile_table.hpp"

namespace sextant {

bool is_given(const ProfileParameters& p) {
  return p.shape != ProfileShape::constant || p.value != 0.0 || !p.points.empty() || !p.table.empty();
}

double largest_magnitude(const ProfileParameters& parameters, std::int64_t duration_ns) {
  const bool whole_sine = parameters.shape == ProfileShape::sine &&
                          static_cast<double>(duration_ns) * parameters.frequency_hz >= 1e9;
  if (whole_sine) return std::abs(parameters.value) + std::abs(parameters.amplitude);
  const Profile profile{parameters};
  double most = 0;
  for (std::int64_t t = 0; t <= duration_ns;) {
    const std::int64_t next = profile.next_corner_ns(t);
    const std::int64_t last = std::min(next - 1, duration_ns);
    most = std::max({most, std::abs(profile.value(t)), std::abs(profile.value(last))});
    t = next;
  }
  return most;
}

std::string LoadConfig::validate() const {
  if (kind == Kind::torque && is_given(imposed_speed)) return "speed_rad_s is given, but kind is \"torque\"";
  if (kind == Kind::imposed_speed && is_given(torque))
    return "torque_nm is given, but kind is \"imposed_speed\"";
  return {};
}

MechanicalLoad::Parameters LoadConfig::parameters() const {
  if (kind == Kind::torque) return {torque, {}};
  return {{}, imposed_speed};
}

void describe(Section s, ProfileParameters& p, const char* unit, Range<double> range) {
  s.choice("shape", p.shape,
           {{"constant", ProfileShape::constant},
            {"steps", ProfileShape::steps},
            {"linear", ProfileShape::linear},
            {"sine", ProfileShape::sine},
            {"table", ProfileShape::table}},
           "one value; values held from point to point; straight lines between points; a sine; or straight "
           "lines between the rows of a file");
  const auto quantity = [unit, range](const char* meaning) {
    return Quantity{unit, range.min, range.max, meaning};
  };
  s.number("value", p.value, quantity("of a constant; offset of a sine"));
  s.points("points", p.points, {"time", 0, 1e6}, {"value", range.min, range.max}, unit,
           "of steps and lines: times in s, the first at 0, and values");
  s.number("amplitude", p.amplitude, quantity("of a sine"));
  s.number("frequency_hz", p.frequency_hz, {"Hz", 1e-6, 1e3, "of a sine"});
  s.number("phase_deg", p.phase_deg, {"deg", -360, 360, "of a sine at time zero"});
  s.file("file", p.file, "time_s,value", "of a table",
         [&p, range](const std::string& path) { p.table = read_profile_table(path, range.min, range.max); });
  s.check(p);
}

void describe(Section s, LoadConfig& p) {
  s.choice("kind", p.kind,
           {{"torque", LoadConfig::Kind::torque}, {"imposed_speed", LoadConfig::Kind::imposed_speed}},
           "a load torque, or a machine on the shaft that imposes the speed");
  describe(s.section("torque_nm"), p.torque, "N·m", {-1e5, 1e5});
  describe(s.section("speed_rad_s"), p.imposed_speed, "rad/s", {-1e4, 1e4});
  s.check(p);
}

}  // namespace sextant
