#include "sextant/recording/trace_divider.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 25'000;
constexpr std::uint32_t parts = 10;
constexpr std::int64_t interval_ns = period_ns / parts;
constexpr std::int64_t periods = 40;

/// A plant whose torque runs linearly between knots at random instants, those of the control periods
/// included.
class RandomPlant {
 public:
  explicit RandomPlant(unsigned seed) {
    std::mt19937_64 random{seed};
    std::uniform_int_distribution<std::int64_t> instant{0, periods * period_ns};
    std::normal_distribution<double> torque{10, 3};
    for (std::int64_t k = 0; k <= periods; ++k) knots_[k * period_ns] = torque(random);
    for (int k = 0; k < 200; ++k) knots_[instant(random)] = torque(random);
    knots_[7 * interval_ns] = 30;  // at the end of a row
  }

  [[nodiscard]] const std::map<std::int64_t, double>& knots() const { return knots_; }

  [[nodiscard]] PlantSample at(std::int64_t t_ns) const {
    const auto after = knots_.lower_bound(t_ns);
    if (after->first == t_ns) return sample(after->second);
    const auto before = std::prev(after);
    const double share = double(t_ns - before->first) / double(after->first - before->first);
    return sample(before->second + share * (after->second - before->second));
  }

  [[nodiscard]] static PlantSample sample(double torque) {
    return {
        .torque = torque, .psi_s = {torque, -torque}, .i_abc = {torque, 0, -torque}, .omega_m = 2 * torque};
  }

 private:
  std::map<std::int64_t, double> knots_;
};

std::vector<TraceRow> rows_of(const RandomPlant& plant) {
  std::vector<TraceRow> rows;
  TraceDivider divider{parts, interval_ns};
  const auto append = [&rows](const TraceRow& row) { rows.push_back(row); };
  auto knot = plant.knots().begin();
  rows.push_back(divider.add({.t_ns = 0, .torque = 0}, RandomPlant::sample(knot->second)));
  for (auto next = std::next(knot); next != plant.knots().end(); knot = next++) {
    divider.add_segment(RandomPlant::sample(knot->second), RandomPlant::sample(next->second),
                        double(next->first - knot->first) * 1e-9, append);
    if (next->first % period_ns != 0) continue;
    const double k = double(next->first / period_ns);
    rows.push_back(divider.add({.t_ns = next->first, .torque = k}, RandomPlant::sample(next->second)));
  }
  return rows;
}

TEST(TraceDivider, RowsAreThoseOfThePlantAtTheirTimes) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const RandomPlant plant{seed};
    const std::vector<TraceRow> rows = rows_of(plant);
    ASSERT_EQ(rows.size(), std::size_t(periods * parts + 1));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const std::int64_t t_ns = std::int64_t(k) * interval_ns;
      const double torque = plant.at(t_ns).torque;
      ASSERT_EQ(rows[k].drive.t_ns, t_ns);
      ASSERT_NEAR(rows[k].plant.torque_nm, torque, 1e-9);
      ASSERT_NEAR(rows[k].plant.omega_m_rad_s, 2 * torque, 1e-9);
      ASSERT_NEAR(rows[k].plant.psi_s_beta_wb, -torque, 1e-9);
      ASSERT_NEAR(rows[k].plant.i_c_a, -torque, 1e-9);
    }
  }
}

TEST(TraceDivider, ARowHasTheExtremesAndTheMeanOfItsInterval) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const RandomPlant plant{seed};
    const std::vector<TraceRow> rows = rows_of(plant);
    for (std::size_t k = 1; k < rows.size(); ++k) {
      const std::int64_t end_ns = std::int64_t(k) * interval_ns;
      std::vector<std::pair<std::int64_t, double>> corners{
          {end_ns - interval_ns, plant.at(end_ns - interval_ns).torque}};
      for (const auto& [t_ns, torque] : plant.knots())
        if (t_ns > end_ns - interval_ns && t_ns < end_ns) corners.emplace_back(t_ns, torque);
      corners.emplace_back(end_ns, plant.at(end_ns).torque);
      double lowest = corners[0].second, highest = lowest, area = 0;
      for (std::size_t c = 1; c < corners.size(); ++c) {
        lowest = std::min(lowest, corners[c].second);
        highest = std::max(highest, corners[c].second);
        area += 0.5 * (corners[c].second + corners[c - 1].second) *
                double(corners[c].first - corners[c - 1].first);
      }
      ASSERT_NEAR(rows[k].plant.torque_min_nm, lowest, 1e-9);
      ASSERT_NEAR(rows[k].plant.torque_max_nm, highest, 1e-9);
      ASSERT_NEAR(rows[k].plant.torque_mean_nm, area / double(interval_ns), 1e-9);
    }
  }
}

TEST(TraceDivider, TheDriveHoldsUntilItsNextPeriod) {
  const std::vector<TraceRow> rows = rows_of(RandomPlant{1});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k].drive.torque_mean_nm, double(k / parts));
    EXPECT_EQ(rows[k].drive.periods, k % parts == 0 ? 1U : 0U);
  }
}

}  // namespace
}  // namespace sextant
