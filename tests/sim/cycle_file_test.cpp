#include "sextant/sim/cycle_file.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_EQ(a.measurement.u_dc, b.measurement.u_dc);
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
  EXPECT_EQ(writer.written(), 3000U);
  writer.close(5);

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
