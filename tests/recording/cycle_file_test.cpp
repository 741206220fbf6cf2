#include "sextant/recording/cycle_file.hpp"

#include <bit>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

namespace sextant {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr unsigned seed = 20261123;

GatePattern random_pattern(std::mt19937& random) {
  GatePattern pattern;
  for (auto n = random() % 9; n > 0; --n) {
    const auto leg = [&] { return LegState{std::uint8_t(random() % 3)}; };
    pattern.append({{leg(), leg(), leg()}, std::int32_t(random() % 25'000)});
  }
  return pattern;
}

CycleRecord<double> random_record(std::mt19937& random) {
  std::uniform_real_distribution<double> number{-1e3, 1e3};
  CycleRecord<double> r;
  r.t_ns = std::int64_t(random()) * 25'000;
  r.measurement = {.i_abc = {number(random), number(random), number(random)},
                   .u_dc = number(random),
                   .omega_m = number(random),
                   .applied = random_pattern(random),
                   .plausible = random() % 2 == 0};
  constexpr double special[]{std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(), -0.0};
  if (random() % 4 == 0) r.measurement.u_dc = special[random() % 3];
  if (random() % 2 == 0) r.measurement.theta_m = number(random);
  r.request.command = {.torque = number(random),
                       .torque_limit = number(random),
                       .enable = random() % 2 == 0,
                       .fault_reset = random() % 2 == 0,
                       .received_ns = std::int64_t(random()),
                       .sequence = random(),
                       .disables = std::uint32_t(random()),
                       .resets = std::uint32_t(random()),
                       .rejected = std::uint32_t(random()),
                       .counter = std::uint8_t(random() % 15),
                       .e2e = E2eState{std::uint8_t(random() % 4)},
                       .out_of_range = std::uint32_t(random()),
                       .bus_off = random() % 2 == 0,
                       .second_sender = random() % 2 == 0};
  r.request.shutdown = random() % 2 == 0;
  r.request.status_age_ns = std::int64_t(random());
  if (random() % 2 == 0) r.request.external.set(Fault::overrun);
  if (random() % 2 == 0) r.request.external.set(Fault::watchdog);
  r.pattern = random_pattern(random);
  return r;
}

void expect_same(const CycleRecord<double>& a, const CycleRecord<double>& b) {
  EXPECT_EQ(a.t_ns, b.t_ns);
  EXPECT_EQ(a.measurement.i_abc, b.measurement.i_abc);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a.measurement.u_dc),
            std::bit_cast<std::uint64_t>(b.measurement.u_dc));
  EXPECT_EQ(a.measurement.omega_m, b.measurement.omega_m);
  EXPECT_EQ(a.measurement.applied, b.measurement.applied);
  EXPECT_EQ(a.measurement.plausible, b.measurement.plausible);
  EXPECT_EQ(a.measurement.theta_m, b.measurement.theta_m);
  const TorqueCommand<double>& c = a.request.command;
  const TorqueCommand<double>& d = b.request.command;
  EXPECT_EQ(c.torque, d.torque);
  EXPECT_EQ(c.torque_limit, d.torque_limit);
  EXPECT_EQ(c.enable, d.enable);
  EXPECT_EQ(c.fault_reset, d.fault_reset);
  EXPECT_EQ(c.received_ns, d.received_ns);
  EXPECT_EQ(c.sequence, d.sequence);
  EXPECT_EQ(c.disables, d.disables);
  EXPECT_EQ(c.resets, d.resets);
  EXPECT_EQ(c.rejected, d.rejected);
  EXPECT_EQ(c.counter, d.counter);
  EXPECT_EQ(c.e2e, d.e2e);
  EXPECT_EQ(c.out_of_range, d.out_of_range);
  EXPECT_EQ(c.bus_off, d.bus_off);
  EXPECT_EQ(c.second_sender, d.second_sender);
  EXPECT_EQ(a.request.shutdown, b.request.shutdown);
  EXPECT_EQ(a.request.status_age_ns, b.request.status_age_ns);
  EXPECT_EQ(a.request.external, b.request.external);
  EXPECT_EQ(a.pattern, b.pattern);
}

class CycleFileTest : public ::testing::Test {
 protected:
  CycleFileTest() { std::filesystem::create_directories(folder_); }
  ~CycleFileTest() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const char* name) const { return (folder_ / name).string(); }

  const std::filesystem::path folder_{std::filesystem::path{::testing::TempDir()} /
                                      ::testing::UnitTest::GetInstance()->current_test_info()->name()};
};

TEST_F(CycleFileTest, HoldsEveryMemberBitForBit) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  std::vector<CycleRecord<double>> records;
  for (int k = 0; k < 3000; ++k) records.push_back(random_record(random));
  CycleFileWriter writer{path("run.h5"), "drive_id = 7\n"};
  writer.append({records.data(), 1});
  writer.append({records.data() + 1, 2000});
  writer.append({records.data() + 2001, 999});
  writer.close(5);
  EXPECT_EQ(writer.written(), 3000U);

  CycleFileReader reader{path("run.h5")};
  EXPECT_EQ(reader.configuration(), "drive_id = 7\n");
  EXPECT_THAT(reader.version(), ::testing::MatchesRegex("[0-9]+[.][0-9]+[.][0-9]+"));
  EXPECT_EQ(reader.size(), 3000U);
  EXPECT_EQ(reader.dropped(), 5U);
  std::size_t at = 0;
  for (auto part = reader.next(700); !part.empty(); part = reader.next(700)) {
    for (const CycleRecord<double>& record : part) expect_same(record, records.at(at++));
  }
  EXPECT_EQ(at, 3000U);
}

TEST_F(CycleFileTest, IsWholeWithoutItsEnd) {
  std::mt19937 random{seed};
  std::vector<CycleRecord<double>> records;
  for (int k = 0; k < 20'000; ++k) records.push_back(random_record(random));
  CycleFileWriter writer{path("run.h5"), ""};
  for (std::size_t k = 0; k < records.size(); k += 1000) writer.append({records.data() + k, 1000});
  // As a killed program leaves it.
  std::filesystem::copy_file(path("run.h5"), path("copy.h5"));
  CycleFileReader reader{path("copy.h5")};
  EXPECT_EQ(reader.size(), writer.written());
  EXPECT_GT(reader.size(), 10'000U);
  EXPECT_FALSE(reader.dropped());
  std::size_t at = 0;
  for (auto part = reader.next(); !part.empty(); part = reader.next()) {
    for (const CycleRecord<double>& record : part) expect_same(record, records.at(at++));
  }
  EXPECT_EQ(at, reader.size());
}

TEST_F(CycleFileTest, KeepsWhatHadRoom) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  std::mt19937 random{seed};
  std::vector<CycleRecord<double>> records;
  for (int k = 0; k < 8192; ++k) records.push_back(random_record(random));
  CycleFileWriter writer{path("run.h5"), ""};
  const rlimit limit{.rlim_cur = 7'000'000, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto fill = [&] {
    for (int k = 0; k < 20; ++k) writer.append(records);
  };
  EXPECT_THAT(fill, ThrowsMessage<std::runtime_error>(HasSubstr("run.h5 cannot be written: File too large")));
  writer.append(records);
  writer.close(0);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  CycleFileReader reader{path("run.h5")};
  EXPECT_EQ(reader.size(), writer.written());
  EXPECT_EQ(reader.size() % records.size(), 0U);
  EXPECT_GT(reader.size(), 0U);
  EXPECT_FALSE(reader.dropped()) << "its end is missing";
  std::size_t at = 0;
  for (auto part = reader.next(); !part.empty(); part = reader.next()) {
    for (const CycleRecord<double>& record : part) expect_same(record, records.at(at++ % records.size()));
  }
}

TEST_F(CycleFileTest, ReplacesNothingButItsKind) {
  CycleFileWriter{path("run.h5"), "first"}.close(0);
  CycleFileWriter{path("run.h5"), "second"}.close(0);
  EXPECT_EQ(CycleFileReader{path("run.h5")}.configuration(), "second");
  std::ofstream{path("notes")} << "mine";
  EXPECT_THAT([&] { CycleFileWriter(path("notes"), ""); },
              ThrowsMessage<std::runtime_error>(HasSubstr("is there and no recording of control periods")));
  EXPECT_EQ(std::filesystem::file_size(path("notes")), 4U);
}

TEST_F(CycleFileTest, AConfigurationMayBeLong) {
  const std::string text(200'000, 'x');
  CycleFileWriter{path("run.h5"), text}.close(0);
  const CycleFileReader reader{path("run.h5")};
  EXPECT_EQ(reader.configuration(), text);
  EXPECT_EQ(reader.size(), 0U);
}

TEST_F(CycleFileTest, RefusesOtherFilesInOneSentence) {
  const auto refused = [&](const std::string& reason) {
    EXPECT_THAT([&] { CycleFileReader{path("file")}; },
                ThrowsMessage<std::runtime_error>(HasSubstr("file is no recording of control periods")));
    EXPECT_THAT([&] { CycleFileReader{path("file")}; }, ThrowsMessage<std::runtime_error>(HasSubstr(reason)));
  };
  refused("No such file");
  std::ofstream{path("file")} << "drive_id = 7\n";
  refused("signature");
  EXPECT_THAT([&] { CycleFileWriter(path("none/run.h5"), ""); },
              ThrowsMessage<std::runtime_error>(HasSubstr("none/run.h5 cannot be written: No such file")));
}

}  // namespace
}  // namespace sextant
