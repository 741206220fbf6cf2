#include "sextant/run/summary.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sextant {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class SummaryFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "sextant_summary_XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& e : std::filesystem::directory_iterator{folder_}) names.push_back(e.path().filename());
    return names;
  }
  [[nodiscard]] std::string read(const char* name) const {
    std::ifstream in{folder_ / name};
    return {std::istreambuf_iterator<char>{in}, {}};
  }

  std::filesystem::path folder_;
};

/// Of a run whose energies add up.
RunSummary balanced() {
  RunSummary s{.scenario = "x"};
  s.metrics[Metric::energy_unaccounted] = 0;
  return s;
}

RunSummary example() {
  RunSummary s = balanced();
  s.scenario = "paper_3_1";
  s.metrics[Metric::torque_ripple_pp] = 9.25;
  s.metrics[Metric::torque_bias] = -0.3;
  const std::vector<Expectation> e{
      {"torque_ripple_pp_nm", {}, 12.0}, {"torque_bias_nm", -0.2, 0.2}, {"response_time_ms", {}, 4.0}};
  s.expectations = evaluate(e, s.metrics);
  return s;
}

TEST_F(SummaryFile, HoldsScenarioMetricsAndEvaluatedExpectations) {
  write_summary(example(), folder_ / "summary.json");
  const auto json = nlohmann::json::parse(read("summary.json"));
  EXPECT_EQ(json.at("scenario"), "paper_3_1");
  EXPECT_EQ(json.at("metrics").size(), metric_count);
  EXPECT_EQ(json.at("metrics").at("torque_ripple_pp_nm"), 9.25);
  EXPECT_TRUE(json.at("metrics").at("response_time_ms").is_null());
  const auto& expect = json.at("expect");
  ASSERT_EQ(expect.size(), 3U);
  EXPECT_EQ(
      expect[0],
      (nlohmann::json{
          {"metric", "torque_ripple_pp_nm"}, {"limit", {{"max", 12.0}}}, {"value", 9.25}, {"pass", true}}));
  EXPECT_EQ(expect[1].at("limit"), (nlohmann::json{{"min", -0.2}, {"max", 0.2}}));
  EXPECT_EQ(expect[1].at("pass"), false);
  EXPECT_TRUE(expect[2].at("value").is_null());
  EXPECT_EQ(expect[2].at("pass"), false);
}

TEST_F(SummaryFile, TheFirstVerdictThatAppliesCounts) {
  RunSummary s = balanced();
  EXPECT_EQ(s.verdict(), Verdict::nothing_expected);
  s.expectations = evaluate(std::vector<Expectation>{{"energy_unaccounted", {}, 1.0}}, s.metrics);
  EXPECT_EQ(s.verdict(), Verdict::pass);
  s.expectations = evaluate(std::vector<Expectation>{{"torque_bias_nm", {}, 1.0}}, s.metrics);
  EXPECT_EQ(s.verdict(), Verdict::fail);
  s.cycle_departure = CycleDeparture{.duration_ns = 2'000'000'000, .farthest = 3};
  EXPECT_EQ(s.verdict(), Verdict::not_followed);
  s.missing_torque = MissingTorque{.asked = 20};
  EXPECT_EQ(s.verdict(), Verdict::no_torque);
  s.trace_error = "disk full";
  EXPECT_EQ(s.verdict(), Verdict::trace_incomplete);
  s.metrics[Metric::energy_unaccounted] = 1.1e-4;
  EXPECT_EQ(s.verdict(), Verdict::not_balanced);
  s.metrics[Metric::energy_unaccounted] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(s.verdict(), Verdict::not_balanced);
  s.metrics[Metric::energy_unaccounted] = 0.9e-4;
  EXPECT_EQ(s.verdict(), Verdict::trace_incomplete);
  s.faults = {{Fault::over_current, 5'000'000}};
  EXPECT_EQ(s.verdict(), Verdict::tripped);
  s.plant_healthy = false;
  EXPECT_EQ(s.verdict(), Verdict::plant_failed);
  s.stopped = true;
  EXPECT_EQ(s.verdict(), Verdict::interrupted);
}

TEST_F(SummaryFile, AnExpectedFaultIsTheFirstOneInItsWindow) {
  RunSummary s = balanced();
  s.expected_fault = FaultExpectation{Fault::over_current, {1'000, 2'000}};
  EXPECT_EQ(s.verdict(), Verdict::fail) << "it has not come";
  s.faults = {{Fault::over_current, 1'500}, {Fault::dc_over_voltage, 1'600}};
  EXPECT_EQ(s.verdict(), Verdict::pass);
  EXPECT_EQ(nlohmann::json::parse(to_json(s)).at("faults")[1].at("fault"), "DC_OVER_VOLTAGE");
  s.faults[0].t_ns = 2'500;
  EXPECT_EQ(s.verdict(), Verdict::tripped) << "too late";
  s.faults = {{Fault::dc_over_voltage, 1'500}, {Fault::over_current, 1'600}};
  EXPECT_EQ(s.verdict(), Verdict::tripped) << "another one was first";
}

TEST_F(SummaryFile, AnExpectedFaultOfTheHandShakeCountsAsOneAtZero) {
  RunSummary s = balanced();
  s.expected_fault = FaultExpectation{.fault = Fault::over_speed};
  s.faults = {{Fault::over_speed, -500'000}};
  EXPECT_EQ(s.verdict(), Verdict::pass) << "at power-up";
  s.expected_fault->window = {0, 1'000};
  EXPECT_EQ(s.verdict(), Verdict::pass);
  s.expected_fault->window = {1, 1'000};
  EXPECT_EQ(s.verdict(), Verdict::tripped) << "it was to come later";
}

TEST_F(SummaryFile, ADriveThatTripsAsExpectedOwesNothing) {
  RunSummary s = balanced();
  s.missing_torque = MissingTorque{.asked = 20};
  s.cycle_departure = CycleDeparture{.duration_ns = 2'000'000'000, .farthest = 3};
  s.expected_fault = FaultExpectation{.fault = Fault::flux_lost};
  s.faults = {{Fault::flux_lost, 1'000}};
  EXPECT_EQ(s.verdict(), Verdict::pass);
}

TEST_F(SummaryFile, ARunOfWhichNothingIsExpectedFailsOnlyWhereThatIsRequired) {
  RunSummary s = balanced();
  EXPECT_EQ(s.status(), 0);
  s.expectations_required = true;
  EXPECT_EQ(s.status(), 9);
  EXPECT_EQ(nlohmann::json::parse(to_json(s)).at("verdict"), "nothing_expected");
  s.expected_fault = FaultExpectation{.fault = Fault::flux_lost};
  s.faults = {{Fault::flux_lost, 1'000}};
  EXPECT_EQ(s.status(), 0) << "a fault is an expectation";
}

TEST_F(SummaryFile, IsKnownAgainByItsScenario) {
  write_summary(example(), folder_ / "summary.json");
  EXPECT_EQ(scenario_of_summary(folder_ / "summary.json"), "paper_3_1");
  std::ofstream{folder_ / "mine.json"} << R"({"scenario": "x"})";
  EXPECT_FALSE(scenario_of_summary(folder_ / "mine.json"));
  std::ofstream{folder_ / "text"} << "no JSON";
  EXPECT_FALSE(scenario_of_summary(folder_ / "text"));
  EXPECT_FALSE(scenario_of_summary(folder_ / "missing"));
}

TEST_F(SummaryFile, KeepsTheOrderOfTheCatalogue) {
  const std::string json = to_json(example());
  std::size_t last = 0;
  for (const MetricInfo& m : metric_catalogue) {
    const auto at = json.find(std::string{"\""} + m.name + "\"");
    ASSERT_NE(at, std::string::npos) << m.name;
    EXPECT_GT(at, last) << m.name;
    last = at;
  }
}

TEST_F(SummaryFile, ReplacesAnOldFileAndLeavesNoOther) {
  std::ofstream{folder_ / "summary.json"} << std::string(100'000, 'x');
  write_summary(example(), folder_ / "summary.json");
  EXPECT_EQ(read("summary.json"), to_json(example()));
  EXPECT_THAT(files(), ElementsAre("summary.json"));
}

TEST_F(SummaryFile, SaysWhichFileCannotBeWrittenAndWhy) {
  try {
    write_summary(example(), folder_ / "missing" / "summary.json");
    FAIL() << "accepted";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(),
                HasSubstr("missing/summary.json: cannot write the summary: No such file or directory"));
  }
  std::filesystem::create_directories(folder_ / "taken" / "inside");
  EXPECT_THROW(write_summary(example(), folder_ / "taken"), std::runtime_error);
  EXPECT_THAT(files(), ElementsAre("taken")) << "the part file stayed behind";
}

TEST(Summary, PassesOnlyIfEveryExpectationHolds) {
  EXPECT_TRUE(RunSummary{}.passed());
  EXPECT_FALSE(example().passed());
  RunSummary s = example();
  s.expectations.resize(1);
  EXPECT_TRUE(s.passed());
}

TEST(Summary, ScenarioNameThatIsNotUtf8IsReplaced) {
  RunSummary s;
  s.scenario = "bad\xff";
  EXPECT_TRUE(nlohmann::json::accept(to_json(s)));
}

TEST(Summary, TableShowsValueUnitLimitAndVerdictInAlignedColumns) {
  const std::string table = format_summary(example(), false);
  EXPECT_THAT(table, HasSubstr("paper_3_1: FAIL\n"));
  EXPECT_THAT(table, HasSubstr("torque_ripple_pp_nm              9.25 N·m    ≤ 12              pass\n"));
  EXPECT_THAT(table, HasSubstr("torque_bias_nm                   -0.3 N·m    -0.2 … 0.2        FAIL\n"));
  EXPECT_THAT(table, HasSubstr("response_time_ms                    - ms     ≤ 4               FAIL\n"));
  EXPECT_THAT(table, Not(HasSubstr("\x1b")));
  EXPECT_THAT(format_summary(example(), true), HasSubstr("\x1b[1;31mFAIL\x1b[0m"));
}

TEST(Summary, HasNoColourWhenTheOutputIsNoTerminal) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  print_summary(example(), file);
  std::rewind(file);
  std::string text(10'000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  EXPECT_EQ(text, format_summary(example(), false));
}

}  // namespace
}  // namespace sextant
