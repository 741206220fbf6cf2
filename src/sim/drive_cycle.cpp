#include "sextant/sim/drive_cycle.hpp"

#include <array>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sextant/sim/csv_table.hpp"

namespace sextant {
namespace {

struct SpeedColumn {
  const char* name;
  double unit;  // [m/s]
};
constexpr std::array<SpeedColumn, 3> speed_columns{
    {{"speed_mph", 0.44704}, {"speed_kmh", 1.0 / 3.6}, {"speed_m_s", 1.0}}};

const SpeedColumn& speed_column(const CsvTable& table) {
  const SpeedColumn* found = nullptr;
  int count = 0;
  for (const SpeedColumn& candidate : speed_columns) {
    for (const std::string& name : table.columns) {
      if (name != candidate.name) continue;
      found = &candidate;
      ++count;
    }
  }
  if (count == 1) return *found;
  throw std::runtime_error{
      fmt::format("{}:{}: expected one of the columns speed_mph, speed_kmh and speed_m_s, found {}",
                  table.file, table.heading_line, fmt::join(table.columns, ","))};
}

}  // namespace

ProfileParameters read_drive_cycle(const std::string& file) {
  const CsvTable table = read_csv(file);
  const std::size_t time = table.column("time_s");
  const SpeedColumn& speed = speed_column(table);
  const std::size_t speed_index = table.column(speed.name);
  ProfileParameters cycle{.shape = ProfileShape::linear};
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    cycle.points.push_back({table.rows[k][time], table.rows[k][speed_index] * speed.unit});
    // Steps, because a cycle cannot have two speeds at one time.
    if (const std::string wrong = validate_point(cycle.points, k, ProfileShape::steps); !wrong.empty())
      throw std::runtime_error{fmt::format("{}: time_s: {}", table.place(k), wrong)};
    if (cycle.points.back().value < 0) {
      throw std::runtime_error{fmt::format("{}: {} must not be below zero, found {}", table.place(k),
                                           speed.name, table.rows[k][speed_index])};
    }
  }
  if (table.rows.size() < 2)
    throw std::runtime_error{fmt::format("{}: a drive cycle needs at least two rows", table.place(0))};
  return cycle;
}

}  // namespace sextant
