#include "sextant/profiles/drive_cycle.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sextant/files/csv_table.hpp"

namespace sextant {
namespace {

struct Unit {
  const char* column;
  double size;  // in that of the profile
};
constexpr std::array<Unit, 3> speed_units{
    {{"speed_mph", 0.44704}, {"speed_kmh", 1.0 / 3.6}, {"speed_m_s", 1.0}}};
constexpr std::array<Unit, 2> grade_units{{{"grade", 1.0}, {"grade_percent", 0.01}}};

/// Those of the units that the table has a column of.
template <std::size_t count>
std::vector<Unit> units_in(const CsvTable& table, const std::array<Unit, count>& units) {
  std::vector<Unit> found;
  std::ranges::copy_if(units, std::back_inserter(found), [&table](const Unit& unit) {
    return std::ranges::find(table.columns, unit.column) != table.columns.end();
  });
  return found;
}

/// A column over time.
ProfileParameters profile_of(const CsvTable& table, const Unit& unit) {
  const std::size_t time = table.column("time_s");
  const std::size_t value = table.column(unit.column);
  ProfileParameters profile{.shape = ProfileShape::linear};
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    profile.points.push_back({table.rows[k][time], table.rows[k][value] * unit.size});
    // Steps, because a cycle cannot have two speeds at one time.
    if (const std::string wrong = validate_point(profile.points, k, ProfileShape::steps); !wrong.empty())
      throw std::runtime_error{fmt::format("{}: time_s: {}", table.place(k), wrong)};
  }
  return profile;
}

void expect_forwards(const CsvTable& table, const ProfileParameters& speed, const Unit& unit) {
  for (std::size_t k = 0; k < speed.points.size(); ++k) {
    if (speed.points[k].value >= 0) continue;
    throw std::runtime_error{fmt::format("{}: {} must not be below zero, found {}", table.place(k),
                                         unit.column, table.rows[k][table.column(unit.column)])};
  }
}

}  // namespace

DriveCycle read_drive_cycle(const std::string& file) {
  const CsvTable table = read_csv(file);
  const std::vector<Unit> speeds = units_in(table, speed_units);
  const std::vector<Unit> grades = units_in(table, grade_units);
  (void)table.column("time_s");
  if (speeds.size() != 1 || grades.size() > 1) {
    throw std::runtime_error{fmt::format(
        "{}:{}: expected one of the columns speed_mph, speed_kmh and speed_m_s, and at most one of grade and "
        "grade_percent, found {}",
        table.file, table.heading_line, fmt::join(table.columns, ","))};
  }
  table.expect_only({"time_s", "speed_mph", "speed_kmh", "speed_m_s", "grade", "grade_percent"});
  DriveCycle cycle{.speed = profile_of(table, speeds.front())};
  expect_forwards(table, cycle.speed, speeds.front());
  if (!grades.empty()) cycle.grade = profile_of(table, grades.front());
  if (table.rows.size() < 2)
    throw std::runtime_error{fmt::format("{}: a drive cycle needs at least two rows", table.place(0))};
  return cycle;
}

}  // namespace sextant
