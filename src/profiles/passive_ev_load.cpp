#include "sextant/profiles/passive_ev_load.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "sextant/files/csv_table.hpp"

namespace sextant {
namespace {

using Row = PassiveEvLoad::Row;

constexpr double m_s_per_kmh = 1.0 / 3.6;
constexpr double rad_s_per_rpm = 2.0 * std::numbers::pi / 60.0;

std::string validate_row(const std::vector<Row>& rows, std::size_t k) {
  const auto [speed, torque, wheel_speed] = rows[k];
  if (!(std::isfinite(speed) && std::isfinite(torque) && std::isfinite(wheel_speed)))
    return fmt::format("row {}: all values must be finite", k);
  if (!(speed > 0)) return fmt::format("row {}: the vehicle speed must be above zero", k);
  if (k > 0 && !(speed > rows[k - 1].speed))
    return fmt::format("row {}: the vehicle speed must rise from row to row", k);
  return {};
}

double slope(const Row& a, const Row& b, double Row::* column) noexcept {
  return (b.*column - a.*column) / (b.speed - a.speed);
}

}  // namespace

std::string PassiveEvLoad::Parameters::validate() const {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (std::string wrong = validate_row(rows, k); !wrong.empty()) return wrong;
  }
  return rows.size() < 2 ? "the table needs at least two rows" : "";
}

PassiveEvLoad::PassiveEvLoad(const Parameters& parameters) : rows_{parameters.rows} {
  if (const std::string wrong = parameters.validate(); !wrong.empty())
    throw std::runtime_error{"passive EV load: " + wrong};
  const Row& first = rows_.front();
  const Row& last = rows_.back();
  const Row& before_last = *(rows_.end() - 2);
  wheel_slope_below_ = first.wheel_speed / first.speed;
  wheel_slope_above_ = slope(before_last, last, &Row::wheel_speed);
  if (parameters.extrapolation == Extrapolation::clip) return;
  torque_slope_above_ = slope(before_last, last, &Row::torque);
  torque_slope_below_ = parameters.extrapolation == Extrapolation::origin
                            ? first.torque / first.speed
                            : slope(first, rows_[1], &Row::torque);
}

double PassiveEvLoad::torque(double speed) const noexcept {
  return looked_up(speed, &Row::torque, torque_slope_below_, torque_slope_above_);
}

double PassiveEvLoad::wheel_speed(double speed) const noexcept {
  return looked_up(speed, &Row::wheel_speed, wheel_slope_below_, wheel_slope_above_);
}

double PassiveEvLoad::looked_up(double speed, double Row::* column, double slope_below,
                                double slope_above) const noexcept {
  const Row& first = rows_.front();
  const Row& last = rows_.back();
  if (speed <= first.speed) return first.*column + slope_below * (speed - first.speed);
  if (speed >= last.speed) return last.*column + slope_above * (speed - last.speed);
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), speed,
                                      [](double v, const Row& row) { return v < row.speed; });
  const Row& before = *std::prev(after);
  return before.*column + slope(before, *after, column) * (speed - before.speed);
}

std::vector<ProfilePoint> PassiveEvLoad::crossings(ProfilePoint from, ProfilePoint to) const {
  const auto [low, high] = std::minmax(from.value, to.value);
  const auto ns = [](double t_s) { return std::llround(t_s * 1e9); };
  std::vector<ProfilePoint> found;
  for (const Row& row : rows_) {
    if (!(row.speed > low && row.speed < high)) continue;
    const double t_s = from.t_s + (to.t_s - from.t_s) * (row.speed - from.value) / (to.value - from.value);
    // Two points within a nanosecond would be a jump.
    if (ns(t_s) > ns(from.t_s) && ns(t_s) < ns(to.t_s)) found.push_back({t_s, row.speed});
  }
  if (from.value > to.value) std::reverse(found.begin(), found.end());
  return found;
}

PassiveEvLoad::Profiles PassiveEvLoad::along(const ProfileParameters& speed) const {
  Profiles profiles;
  profiles.torque.shape = ProfileShape::linear;
  profiles.wheel_speed.shape = ProfileShape::linear;
  const auto add = [this, &profiles](ProfilePoint p) {
    profiles.torque.points.push_back({p.t_s, torque(p.value)});
    profiles.wheel_speed.points.push_back({p.t_s, wheel_speed(p.value)});
  };
  for (std::size_t k = 0; k < speed.points.size(); ++k) {
    add(speed.points[k]);
    if (k + 1 == speed.points.size()) break;
    for (const ProfilePoint p : crossings(speed.points[k], speed.points[k + 1])) add(p);
  }
  return profiles;
}

std::vector<Row> read_passive_ev_table(const std::string& file) {
  const CsvTable table = read_csv(file);
  const std::size_t torque = table.column("torque_nm");
  const std::size_t speed = table.column("vehicle_speed_kmh");
  const std::size_t wheel = table.column("wheel_speed_rpm");
  table.expect_only({"torque_nm", "vehicle_speed_kmh", "wheel_speed_rpm"});
  std::vector<Row> rows;
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    const std::vector<double>& cells = table.rows[k];
    rows.push_back({cells[speed] * m_s_per_kmh, cells[torque], cells[wheel] * rad_s_per_rpm});
    if (const std::string wrong = validate_row(rows, k); !wrong.empty())
      throw std::runtime_error{fmt::format("{}: vehicle_speed_kmh: {}", table.place(k), wrong)};
  }
  if (rows.size() < 2)
    throw std::runtime_error{fmt::format("{}: the table needs at least two rows", table.place(0))};
  return rows;
}

}  // namespace sextant
