#include "sextant/profiles/profile_table.hpp"

#include <stdexcept>

#include <fmt/format.h>

#include "sextant/files/csv_table.hpp"

namespace sextant {

std::vector<ProfilePoint> read_profile_table(const std::string& file, double min, double max) {
  const CsvTable table = read_csv(file);
  const std::size_t time = table.column("time_s");
  const std::size_t value = table.column("value");
  table.expect_only({"time_s", "value"});
  ProfileParameters profile{.shape = ProfileShape::table};
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    const ProfilePoint point{table.rows[k][time], table.rows[k][value]};
    profile.table.push_back(point);
    if (point.value < min || point.value > max) {
      throw std::runtime_error{
          fmt::format("{}: value must be from {} to {}, not {}", table.place(k), min, max, point.value)};
    }
    if (const std::string wrong = validate_point(profile.table, k, profile.shape); !wrong.empty())
      throw std::runtime_error{fmt::format("{}: time_s: {}", table.place(k), wrong)};
  }
  return profile.table;
}

}  // namespace sextant
