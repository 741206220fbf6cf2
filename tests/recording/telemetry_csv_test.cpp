#include "sextant/recording/telemetry_csv.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class TelemetryCsvTest : public ::testing::Test {
 protected:
  TelemetryCsvTest() {
    std::string name = (std::filesystem::temp_directory_path() / "sextant-csv-XXXXXX").string();
    directory = ::mkdtemp(name.data());
  }
  ~TelemetryCsvTest() override { std::filesystem::remove_all(directory); }

  std::filesystem::path directory;
};

TEST_F(TelemetryCsvTest, WritesAHeadingAndARecordALine) {
  const std::string file = (directory / "a.csv").string();
  TelemetryCsv csv{file};
  csv.add({.t_ns = 1'975'000,
           .periods = 40,
           .torque_requested_nm = 0.1,
           .torque_mean_nm = 1.0 / 3.0,
           .torque_max_nm = std::numeric_limits<double>::quiet_NaN(),
           .state = DriveState::torque,
           .sector = 6,
           .command_counter = 14,
           .command_received_ns = -1});
  csv.close();
  std::ifstream stream{file};
  std::string heading;
  std::string record;
  ASSERT_TRUE(std::getline(stream, heading));
  ASSERT_TRUE(std::getline(stream, record));
  EXPECT_THAT(heading, StartsWith("t_ns,periods,torque_requested_nm,torque_reference_nm,torque_mean_nm,"));
  EXPECT_THAT(record, StartsWith("1975000,40,0.1,0,0.3333333333333333,0,nan,"));
  EXPECT_THAT(record, HasSubstr(",TORQUE,6,14,-1"));
  EXPECT_EQ(std::ranges::count(heading, ','), std::ranges::count(record, ','));
  EXPECT_FALSE(std::getline(stream, record));
}

TEST_F(TelemetryCsvTest, SaysWhatItCannotWrite) {
  const auto complaint = [](const std::string& file) -> std::string {
    try {
      TelemetryCsv csv{file};
      for (int n = 0; n < 1000; ++n) csv.add({.t_ns = n});
      csv.close();
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "none";
  };
  EXPECT_THAT(complaint((directory / "no" / "a.csv").string()), HasSubstr("cannot be written: No such file"));
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_THAT(complaint("/dev/full"), HasSubstr("/dev/full cannot be written"));
  }
}

}  // namespace
}  // namespace sextant
