#include "sextant/run/expectation.hpp"

#include <array>
#include <limits>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

using testing::HasSubstr;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(MetricList, EveryMetricIsFoundByItsOwnName) {
  std::set<std::string> names;
  for (std::size_t k = 0; k < metric_count; ++k) {
    const auto metric = find_metric(metric_catalogue[k].name);
    ASSERT_TRUE(metric.has_value()) << k;
    EXPECT_EQ(static_cast<std::size_t>(*metric), k);
    names.insert(metric_catalogue[k].name);
  }
  EXPECT_EQ(names.size(), metric_count);
  EXPECT_STREQ(info(Metric::realtime_factor).name, "realtime_factor");
  EXPECT_STREQ(info(Metric::current_thd).name, "current_thd_percent");
  EXPECT_FALSE(find_metric("torque_ripple"));
  EXPECT_FALSE(find_metric(""));
}

TEST(MetricList, HasNoValueUntilOneIsSet) {
  MetricList m;
  for (const double v : m.values()) EXPECT_TRUE(std::isnan(v));
  m[Metric::wall] = 2;
  EXPECT_EQ(m.values()[static_cast<std::size_t>(Metric::wall)], 2);
}

TEST(Expectation, EvaluatesBoundsInclusively) {
  struct Case {
    std::optional<double> min;
    std::optional<double> max;
    double value;
    bool pass;
  };
  const std::array<Case, 10> cases{{{{}, 3, 3, true},
                                    {{}, 3, std::nextafter(3, 4), false},
                                    {3, {}, 3, true},
                                    {3, {}, std::nextafter(3, 2), false},
                                    {-1, 1, 0, true},
                                    {-1, 1, 1.5, false},
                                    {-1, 1, -1.5, false},
                                    {-1, 1, nan, false},
                                    {{}, 3, nan, false},
                                    {{}, 3, std::numeric_limits<double>::infinity(), false}}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    SCOPED_TRACE(k);
    MetricList m;
    m[Metric::torque_bias] = cases[k].value;
    const std::array e{Expectation{"torque_bias_nm", cases[k].min, cases[k].max}};
    const auto results = evaluate(e, m);
    ASSERT_EQ(results.size(), 1U);
    EXPECT_EQ(results[0].pass, cases[k].pass);
    EXPECT_EQ(results[0].limit.metric, "torque_bias_nm");
  }
}

TEST(Expectation, KeepsOrderAndFailsAnUnknownMetric) {
  MetricList m;
  m[Metric::wall] = 1;
  const std::array e{Expectation{"wall_s", 0, {}}, Expectation{"no_such_metric", 0, {}}};
  const auto results = evaluate(e, m);
  ASSERT_EQ(results.size(), 2U);
  EXPECT_TRUE(results[0].pass);
  EXPECT_EQ(results[1].limit.metric, "no_such_metric");
  EXPECT_FALSE(results[1].pass);
  EXPECT_TRUE(evaluate({}, m).empty());
}

TEST(Expectation, ValidateNamesWhatIsWrong) {
  EXPECT_EQ((Expectation{"wall_s", 0, 1}.validate()), "");
  EXPECT_EQ((Expectation{"wall_s", 1, 1}.validate()), "");
  EXPECT_THAT((Expectation{"wall", 0, 1}.validate()), HasSubstr("no metric 'wall'"));
  EXPECT_THAT((Expectation{"wall", 0, 1}.validate()), HasSubstr("realtime_factor"));
  EXPECT_THAT((Expectation{"wall_s", {}, {}}.validate()), HasSubstr("give min, max or both"));
  EXPECT_THAT((Expectation{"wall_s", nan, {}}.validate()), HasSubstr("finite"));
  EXPECT_THAT((Expectation{"wall_s", {}, nan}.validate()), HasSubstr("finite"));
  EXPECT_THAT((Expectation{"wall_s", 2, 1}.validate()), HasSubstr("min 2 is above max 1"));
}

}  // namespace
}  // namespace sextant
