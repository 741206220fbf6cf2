#include "sextant/recording/trace_recorder.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <regex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/source_directory.hpp"

namespace sextant {
namespace {

using testing::HasSubstr;

constexpr std::int64_t period_ns = 25'000;

/// Reads a trace with HDF5's own interface.
class TraceFile {
 public:
  explicit TraceFile(const std::filesystem::path& file)
      : id_{H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)} {}
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;
  ~TraceFile() {
    if (id_ >= 0) H5Fclose(id_);
  }

  [[nodiscard]] bool is_open() const { return id_ >= 0; }
  [[nodiscard]] bool has(const std::string& name) const {
    return H5Lexists(id_, name.c_str(), H5P_DEFAULT) > 0;
  }

  [[nodiscard]] std::vector<double> read(const std::string& name) const {
    const hid_t set = H5Dopen2(id_, name.c_str(), H5P_DEFAULT);
    if (set < 0) throw std::runtime_error{"no dataset " + name};
    const hid_t space = H5Dget_space(set);
    std::vector<double> values(std::size_t(H5Sget_simple_extent_npoints(space)));
    const hid_t type = H5Dget_type(set);
    herr_t status = 0;
    if (H5Tget_class(type) == H5T_ENUM) {
      std::vector<std::uint8_t> raw(values.size());
      status = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data());
      std::copy(raw.begin(), raw.end(), values.begin());
    } else {
      status = H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    }
    H5Tclose(type);
    H5Sclose(space);
    H5Dclose(set);
    if (status < 0) throw std::runtime_error{"cannot read " + name};
    return values;
  }

  [[nodiscard]] std::string text(const std::string& object, const char* attribute) const {
    const hid_t a = H5Aopen_by_name(id_, object.c_str(), attribute, H5P_DEFAULT, H5P_DEFAULT);
    if (a < 0) return {};
    const hid_t type = H5Aget_type(a);
    std::string value(H5Tget_size(type), '\0');
    H5Aread(a, type, value.data());
    H5Tclose(type);
    H5Aclose(a);
    value.resize(value.find('\0'));
    return value;
  }

  [[nodiscard]] bool has_attribute(const char* attribute) const { return H5Aexists(id_, attribute) > 0; }

  [[nodiscard]] long long integer(const char* attribute) const {
    long long value = -1;
    const hid_t a = H5Aopen_by_name(id_, "/", attribute, H5P_DEFAULT, H5P_DEFAULT);
    H5Aread(a, H5T_NATIVE_LLONG, &value);
    H5Aclose(a);
    return value;
  }

  [[nodiscard]] std::vector<std::string> datasets(const char* group) const {
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
      static_cast<std::vector<std::string>*>(to)->emplace_back(name);
      return 0;
    };
    hsize_t index = 0;
    const hid_t g = H5Gopen2(id_, group, H5P_DEFAULT);
    H5Literate(g, H5_INDEX_NAME, H5_ITER_INC, &index, add, &names);
    H5Gclose(g);
    return names;
  }

 private:
  hid_t id_;
};

class TraceRecorderTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "sextant_trace_XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = folder_ / "trace.h5";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
  std::filesystem::path file_;
};

const TraceOrigin origin{.scenario = "bench run", .control_period_ns = period_ns};

Telemetry<> telemetry(std::int64_t k) {
  return {.t_ns = k * period_ns,
          .u_dc = 530,
          .omega_m = 0.5 * double(k),
          .psi_s_magnitude = 1.1,
          .torque = double(k),
          .sector = std::uint8_t(k % 6 + 1),
          .state = DriveState::torque};
}
PlantSample plant(std::int64_t k) {
  return {
      .torque = -double(k), .tau_l = 3, .psi_s = {0.6, 0.8}, .i_abc = {1, 2, -3}, .u_dc = 529, .omega_m = 40};
}

void record(TraceRecorder& recorder, std::int64_t begin, std::int64_t end) {
  for (std::int64_t k = begin; k < end; ++k) {
    recorder.add_segment(plant(k), plant(k), 1e-9 * double(period_ns));
    recorder.add(telemetry(k), plant(k));
  }
}

/// Runs `body` in a child process and returns what it exits with, or minus the signal that ended it.
template <class Body>
int in_child(Body body) {
  const pid_t child = ::fork();
  if (child == 0) {
    int code = 125;
    try {
      code = body();
    } catch (...) {
    }
    ::_exit(code);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST_F(TraceRecorderTest, OneRowPerIntervalWithMeanMinimumAndMaximum) {
  {
    TraceRecorder recorder{file_, {.interval_us = 1000}, origin};
    record(recorder, 0, 120);
    EXPECT_EQ(recorder.error(), "");
  }
  const TraceFile trace{file_};
  ASSERT_TRUE(trace.is_open());
  EXPECT_THAT(trace.read("t_ns"), testing::ElementsAre(39 * period_ns, 79 * period_ns, 119 * period_ns));
  EXPECT_THAT(trace.read("periods"), testing::ElementsAre(40, 40, 40));
  EXPECT_THAT(trace.read("torque_min_nm"), testing::ElementsAre(0, 40, 80));
  EXPECT_THAT(trace.read("torque_max_nm"), testing::ElementsAre(39, 79, 119));
  EXPECT_THAT(
      trace.read("torque_mean_nm"),
      testing::ElementsAre(testing::DoubleEq(19.5), testing::DoubleEq(59.5), testing::DoubleEq(99.5)));
  EXPECT_THAT(trace.read("state"), testing::Each(double(DriveState::torque)));
  EXPECT_THAT(trace.read("speed_rad_s"), testing::ElementsAre(19.5, 39.5, 59.5));
  EXPECT_THAT(trace.read("plant/torque_nm"), testing::ElementsAre(-39, -79, -119));
  EXPECT_THAT(trace.read("plant/torque_mean_nm"),
              testing::ElementsAre(testing::DoubleNear(-19.5, 1e-12), testing::DoubleNear(-59.5, 1e-12),
                                   testing::DoubleNear(-99.5, 1e-12)));
  EXPECT_THAT(trace.read("plant/torque_min_nm"), testing::ElementsAre(-39, -79, -119));
  EXPECT_THAT(trace.read("plant/torque_max_nm"), testing::ElementsAre(0, -40, -80));
  EXPECT_THAT(trace.read("plant/psi_s_wb"), testing::Each(testing::DoubleEq(1.0)));
  EXPECT_THAT(trace.read("plant/omega_m_rad_s"), testing::Each(40));
  EXPECT_THAT(trace.read("plant/tau_l_nm"), testing::Each(3));
  EXPECT_THAT(trace.read("plant/i_c_a"), testing::Each(-3));
  EXPECT_THAT(trace.read("plant/u_dc_v"), testing::Each(529));
}

TEST_F(TraceRecorderTest, HasEverySignalOfTheIdlWithUnitAndDescription) {
  TraceRecorder{file_, {}, origin};
  std::ifstream idl_file{SEXTANT_SOURCE_DIR "/configs/interfaces/telemetry.idl"};
  const std::string idl{std::istreambuf_iterator<char>{idl_file}, {}};
  const auto begin = idl.find("struct DriveTelemetry");
  ASSERT_NE(begin, std::string::npos);
  const std::string body = idl.substr(begin, idl.find("};", begin) - begin);
  const std::regex member{R"(\n[^/\n]*\b_?([a-z]\w*);)"};
  const TraceFile trace{file_};
  int found = 0;
  for (std::sregex_iterator it{body.begin(), body.end(), member}, end; it != end; ++it) {
    const std::string name = (*it)[1];
    if (name == "drive_id" || name == "sequence" || name == "dropped") continue;
    EXPECT_TRUE(trace.has(name)) << name;
    ++found;
  }
  const auto signals = trace.datasets("/");
  EXPECT_EQ(signals.size(), std::size_t(found) + 1)
      << "the root holds the signals and the group of the plant";
  for (const char* group : {"/", "/plant"}) {
    for (const std::string& name : trace.datasets(group)) {
      if (name == "plant") continue;
      const std::string path = std::string{group} + "/" + name;
      EXPECT_FALSE(trace.text(path, "unit").empty()) << path;
      EXPECT_FALSE(trace.text(path, "description").empty()) << path;
    }
  }
  EXPECT_EQ(trace.text("torque_mean_nm", "unit"), "N·m");
  EXPECT_EQ(trace.text("plant/psi_s_wb", "unit"), "Wb");
}

TEST_F(TraceRecorderTest, HoldsTheSignalsThatAreChosenAndTheTime) {
  const PlantSample sample{.u_dc = 530,
                           .theta_m = 12.5,
                           .i_dc = -7,
                           .state = {LegState::high, LegState::low, LegState::off},
                           .u_s = {100, -50},
                           .i_r = {3, 4},
                           .energies = {.link = 9, .copper = 5, .shaft = 3, .field = 1, .iron = 2},
                           .temperatures = {71, 82, 53},
                           .inverter = {310, 55, {61, 62, 63, 64, 65, 66, 67, 68, 69, 70, 71, 72}}};
  {
    TraceRecorder recorder{file_,
                           {.interval_us = 25,
                            .signals = {"switching", "plant/i_dc_a", "energy", "thermal", "inverter",
                                        "comparators", "monitor", "parameters"}},
                           origin};
    Telemetry<> record = telemetry(1);
    record.torque_monitored = 8.5;
    record.torque_reached = 6.25;
    record.r_s = 0.5;
    record.r_r = 0.9;
    record.l_m = 0.07;
    record.r_s_deviation = 0.31;
    record.r_r_deviation = 0.22;
    record.l_m_deviation = 0.13;
    record.unchecked_periods = 17;
    recorder.add(record, sample, {.torque_comparator = -1, .flux_comparator = 1});
  }
  const TraceFile trace{file_};
  EXPECT_THAT(trace.datasets("/"), testing::UnorderedElementsAre("t_ns", "plant", "control"));
  EXPECT_THAT(
      trace.datasets("/plant"),
      testing::UnorderedElementsAre(
          "switch_a", "switch_b", "switch_c", "i_dc_a", "energy_link_j", "energy_copper_j", "energy_iron_j",
          "energy_shaft_j", "energy_field_j", "winding_temperature_c", "rotor_temperature_c",
          "housing_temperature_c", "energy_inverter_j", "inverter_loss_w", "case_temperature_c",
          "junction_a_upper_switch_c", "junction_a_upper_diode_c", "junction_a_lower_switch_c",
          "junction_a_lower_diode_c", "junction_b_upper_switch_c", "junction_b_upper_diode_c",
          "junction_b_lower_switch_c", "junction_b_lower_diode_c", "junction_c_upper_switch_c",
          "junction_c_upper_diode_c", "junction_c_lower_switch_c", "junction_c_lower_diode_c"));
  EXPECT_THAT(trace.read("plant/inverter_loss_w"), testing::ElementsAre(310));
  EXPECT_THAT(trace.read("plant/case_temperature_c"), testing::ElementsAre(55));
  EXPECT_THAT(trace.read("plant/junction_a_upper_switch_c"), testing::ElementsAre(61));
  EXPECT_THAT(trace.read("plant/junction_b_lower_switch_c"), testing::ElementsAre(67));
  EXPECT_THAT(trace.read("plant/junction_c_lower_diode_c"), testing::ElementsAre(72));
  EXPECT_THAT(trace.read("plant/switch_a"), testing::ElementsAre(1));
  EXPECT_THAT(trace.read("plant/switch_b"), testing::ElementsAre(0));
  EXPECT_THAT(trace.read("plant/switch_c"), testing::ElementsAre(-1));
  EXPECT_THAT(trace.read("plant/i_dc_a"), testing::ElementsAre(-7));
  EXPECT_THAT(trace.read("plant/energy_link_j"), testing::ElementsAre(9));
  EXPECT_THAT(trace.read("plant/energy_field_j"), testing::ElementsAre(1));
  EXPECT_THAT(trace.read("plant/energy_iron_j"), testing::ElementsAre(2));
  EXPECT_THAT(trace.read("plant/winding_temperature_c"), testing::ElementsAre(71));
  EXPECT_THAT(trace.read("plant/rotor_temperature_c"), testing::ElementsAre(82));
  EXPECT_THAT(trace.read("plant/housing_temperature_c"), testing::ElementsAre(53));
  EXPECT_THAT(trace.read("control/torque_comparator"), testing::ElementsAre(-1));
  EXPECT_THAT(trace.read("control/flux_comparator"), testing::ElementsAre(1));
  EXPECT_THAT(trace.read("control/torque_monitored_nm"), testing::ElementsAre(8.5));
  EXPECT_THAT(trace.read("control/torque_reached_nm"), testing::ElementsAre(6.25));
  EXPECT_THAT(trace.read("control/r_s_ohm"), testing::ElementsAre(0.5));
  EXPECT_THAT(trace.read("control/r_r_ohm"), testing::ElementsAre(0.9));
  EXPECT_THAT(trace.read("control/l_m_h"), testing::ElementsAre(0.07));
  EXPECT_THAT(trace.read("control/r_s_deviation"), testing::ElementsAre(0.31));
  EXPECT_THAT(trace.read("control/r_r_deviation"), testing::ElementsAre(0.22));
  EXPECT_THAT(trace.read("control/l_m_deviation"), testing::ElementsAre(0.13));
  EXPECT_THAT(trace.read("control/periods_unchecked"), testing::ElementsAre(17));
}

TEST_F(TraceRecorderTest, HoldsTheChannelsOfAController) {
  constexpr std::array channels{ControlChannel{"i_d_a", "A", "current along the flux"},
                                ControlChannel{"gain", "1", "of a loop"}};
  TraceOrigin with_channels = origin;
  with_channels.channels = channels;
  const auto record = [&](const std::vector<std::string>& signals) {
    TraceRecorder recorder{file_, {.interval_us = 50, .signals = signals}, with_channels};
    for (std::int64_t k = 1; k <= 4; ++k) {
      const std::array values{10.0 * double(k), -double(k)};
      recorder.add(telemetry(k), {}, {.channels = values});
    }
  };
  record({"standard"});
  {
    const TraceFile trace{file_};
    EXPECT_THAT(trace.datasets("/control"), testing::UnorderedElementsAre("i_d_a", "gain"));
    EXPECT_THAT(trace.read("control/i_d_a"), testing::ElementsAre(20, 40)) << "the last of each row";
    EXPECT_THAT(trace.read("control/gain"), testing::ElementsAre(-2, -4));
    EXPECT_EQ(trace.text("control/i_d_a", "unit"), "A");
    EXPECT_EQ(trace.text("control/i_d_a", "description"), "current along the flux");
  }
  record({"control/gain"});
  EXPECT_THAT(TraceFile{file_}.datasets("/control"), testing::UnorderedElementsAre("gain"));
  EXPECT_THROW((TraceRecorder{file_, {.signals = {"control/gain"}}, origin}), std::runtime_error);
}

TEST_F(TraceRecorderTest, HoldsEverySignalOnDemandWithUnitAndDescription) {
  TraceRecorder{file_, {.signals = {"all"}}, origin};
  const TraceFile trace{file_};
  int datasets = 0;
  for (const std::string& name : trace_signals()) {
    if (name == "t_ns" || name.find('_') == std::string::npos) continue;
    ++datasets;
    EXPECT_FALSE(trace.text(name, "unit").empty()) << name;
    EXPECT_FALSE(trace.text(name, "description").empty()) << name;
  }
  EXPECT_GT(datasets, 50);
}

TEST_F(TraceRecorderTest, RefusesASignalThatItDoesNotKnow) {
  EXPECT_THROW((TraceRecorder{file_, {.signals = {"standard", "swiching"}}, origin}), std::runtime_error);
  EXPECT_THROW((TraceRecorder{file_, {.signals = {}}, origin}), std::runtime_error);
}

TEST_F(TraceRecorderTest, IsToldFromOtherFiles) {
  TraceRecorder{file_, {}, origin};
  EXPECT_TRUE(is_trace(file_));
  EXPECT_FALSE(is_trace(folder_));
  EXPECT_FALSE(is_trace(folder_ / "missing.h5"));
  std::ofstream{folder_ / "notes.h5"} << "mine";
  EXPECT_FALSE(is_trace(folder_ / "notes.h5"));
}

TEST_F(TraceRecorderTest, FileSaysWhichRunItBelongsTo) {
  TraceRecorder{file_, {.interval_us = 250}, origin};
  const TraceFile trace{file_};
  EXPECT_EQ(trace.text("/", "scenario"), "bench run");
  EXPECT_THAT(trace.text("/", "sextant_version"), testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
  EXPECT_EQ(trace.text("/", "mode"), "sampled");
  EXPECT_EQ(trace.integer("control_period_ns"), period_ns);
  EXPECT_EQ(trace.integer("interval_ns"), 250'000);
  EXPECT_EQ(trace.integer("begin_ns"), 0);
  EXPECT_THAT(trace.text("/", "decimation"), HasSubstr("nothing of after its t_ns"));
}

TEST_F(TraceRecorderTest, FinishedRowsOfAnEventExactRunAreWrittenAsTheyAre) {
  {
    // An interval that is no whole number of any control period.
    TraceRecorder recorder{file_, {.interval_us = 33.333}, {.scenario = "exact", .control_period_ns = {}}};
    for (int k = 0; k < 3; ++k) {
      TraceRow row;
      row.drive.t_ns = 33'333 * (k + 1);
      row.drive.torque_max_nm = 15.5 + k;
      row.drive.state = DriveState::torque;
      row.drive.sector = std::uint8_t(k + 1);
      row.plant.flux_min_wb = 1.0 + 0.1 * k;
      row.plant.tau_l_nm = 4;
      recorder.add_row(row);
    }
  }
  const TraceFile trace{file_};
  ASSERT_TRUE(trace.is_open());
  EXPECT_THAT(trace.read("t_ns"), testing::ElementsAre(33'333, 66'666, 99'999));
  EXPECT_THAT(trace.read("torque_max_nm"), testing::ElementsAre(15.5, 16.5, 17.5));
  EXPECT_THAT(trace.read("state"), testing::Each(double(DriveState::torque)));
  EXPECT_THAT(trace.read("sector"), testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(trace.read("plant/flux_min_wb"), testing::ElementsAre(1.0, 1.1, 1.2));
  EXPECT_THAT(trace.read("plant/tau_l_nm"), testing::Each(4));
  EXPECT_EQ(trace.text("/", "mode"), "event_exact");
  EXPECT_EQ(trace.integer("interval_ns"), 33'333);
  EXPECT_FALSE(trace.has_attribute("control_period_ns"));
}

TEST_F(TraceRecorderTest, AnEventExactRunHasNoControlPeriods) {
  TraceRecorder recorder{file_, {}, {.scenario = "exact", .control_period_ns = {}}};
  EXPECT_THROW(recorder.add(telemetry(0), plant(0)), std::logic_error);
  EXPECT_THROW(recorder.add_segment(plant(0), plant(0), 1e-6), std::logic_error);
}

TEST_F(TraceRecorderTest, ThePlantsFluxAndCurrentAreAnEnvelope) {
  {
    TraceRecorder recorder{file_, {.interval_us = 100}, origin};
    for (std::int64_t k = 0; k < 4; ++k) {
      PlantSample p = plant(k);
      p.psi_s = polar(1.0 + 0.1 * double(k), double(k));
      p.i_abc = inverse_clarke(polar(k == 1 ? 70.0 : 10.0 + double(k), double(k)));
      recorder.add_segment(p, p, 1e-9 * double(period_ns));
      recorder.add(telemetry(k), p);
    }
  }
  const TraceFile trace{file_};
  const auto near = [](double x) { return testing::ElementsAre(testing::DoubleNear(x, 1e-12)); };
  EXPECT_THAT(trace.read("plant/flux_mean_wb"), near((1.0 + 1.05 + 1.15 + 1.25) / 4));
  EXPECT_THAT(trace.read("plant/flux_min_wb"), near(1.0));
  EXPECT_THAT(trace.read("plant/flux_max_wb"), near(1.3));
  EXPECT_THAT(trace.read("plant/current_min_a"), near(10));
  EXPECT_THAT(trace.read("plant/current_max_a"), near(70));
  EXPECT_THAT(trace.text("/", "decimation"), HasSubstr("min/max envelope"));
}

TEST_F(TraceRecorderTest, TheUnfinishedIntervalIsWrittenAtTheEnd) {
  TraceRecorder recorder{file_, {.interval_us = 1000}, origin};
  record(recorder, 0, 47);
  recorder.close();
  recorder.close();
  record(recorder, 47, 200);
  const TraceFile trace{file_};
  EXPECT_THAT(trace.read("periods"), testing::ElementsAre(40, 7));
}

TEST_F(TraceRecorderTest, CompressionChangesTheSizeAndNotTheValues) {
  const auto plain_file = folder_ / "plain.h5";
  for (const int compression : {0, 1}) {
    TraceRecorder recorder{
        compression == 0 ? plain_file : file_, {.interval_us = 25, .compression = compression}, origin};
    record(recorder, 0, 5'000);
  }
  EXPECT_LT(std::filesystem::file_size(file_), std::filesystem::file_size(plain_file) / 2);
  EXPECT_EQ(TraceFile{file_}.read("torque_mean_nm"), TraceFile{plain_file}.read("torque_mean_nm"));
  EXPECT_EQ(TraceFile{file_}.read("plant/torque_nm"), TraceFile{plain_file}.read("plant/torque_nm"));
}

TEST_F(TraceRecorderTest, AClosedFileHoldsNoRoomThatIsNotItsOwn) {
  {
    TraceRecorder recorder{file_, {.interval_us = 25}, origin};
    record(recorder, 0, 1);
  }
  // One chunk of 1024 values a signal, and the index.
  EXPECT_LT(std::filesystem::file_size(file_), 500'000U);
}

TEST_F(TraceRecorderTest, ManyRowsKeepTheirOrderAcrossBuffersAndFlushes) {
  constexpr std::int64_t rows = 10'001;
  {
    TraceRecorder recorder{file_, {.interval_us = 25}, origin};
    record(recorder, 0, 100);
    recorder.flush();
    record(recorder, 100, rows);
  }
  const auto t = TraceFile{file_}.read("t_ns");
  const auto sector = TraceFile{file_}.read("sector");
  ASSERT_EQ(t.size(), std::size_t(rows));
  ASSERT_EQ(sector.size(), std::size_t(rows));
  for (std::size_t k = 0; k < t.size(); ++k) {
    ASSERT_EQ(t[k], double(k) * double(period_ns));
    ASSERT_EQ(sector[k], double(k % 6 + 1));
  }
}

TEST_F(TraceRecorderTest, AFlushedTraceOfAKilledRunCanBeRead) {
  const int status = in_child([this] {
    TraceRecorder recorder{file_, {.interval_us = 25}, origin};
    record(recorder, 0, 5'000);
    recorder.flush();
    record(recorder, 5'000, 6'000);
    return ::raise(SIGKILL);
  });
  ASSERT_EQ(status, -SIGKILL);
  const TraceFile trace{file_};
  ASSERT_TRUE(trace.is_open());
  for (const char* name : {"t_ns", "torque_mean_nm", "state", "plant/torque_nm", "plant/tau_l_nm"}) {
    EXPECT_EQ(trace.read(name).size(), 5'000U) << name;
  }
  EXPECT_EQ(trace.read("torque_mean_nm")[4'999], 4'999);
}

TEST_F(TraceRecorderTest, FlushesByItselfWhileARunGoesOn) {
  const int status = in_child([this] {
    TraceRecorder recorder{file_, {.interval_us = 25}, origin};
    record(recorder, 0, 50);
    std::this_thread::sleep_for(std::chrono::milliseconds{1'100});
    record(recorder, 50, 60);
    ::_exit(0);
    return 0;
  });
  ASSERT_EQ(status, 0);
  const TraceFile trace{file_};
  ASSERT_TRUE(trace.is_open());
  EXPECT_GE(trace.read("t_ns").size(), 51U);
}

TEST_F(TraceRecorderTest, ReportsAFullDiskOnceAndGoesOn) {
  const int status = in_child([this] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4'000'000, 4'000'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int reports = 0;
    std::string said;
    {
      TraceRecorder recorder{file_, {.interval_us = 25}, origin, [&](const std::string& error) {
                               ++reports;
                               said = error;
                             }};
      record(recorder, 0, 500);
      recorder.flush();
      if (reports != 0) return 1;
      record(recorder, 500, 1'000'000);
      if (reports != 1) return 10 + reports;
      recorder.flush();
      recorder.close();
      if (recorder.error() != said) return 2;
    }
    if (said.find("trace.h5: recording stopped, cannot write the trace: File too large") == std::string::npos)
      return 3;
    // A normal end of the program must work too: HDF5 closes what is left at exit.
    std::exit(reports == 1 ? 0 : 5);
    return 0;
  });
  EXPECT_EQ(status, 0);
  const TraceFile trace{file_};
  ASSERT_TRUE(trace.is_open());
  for (const char* group : {"/", "/plant/"}) {
    for (const std::string& name : trace.datasets(group)) {
      if (name == "plant") continue;
      EXPECT_GE(trace.read(group + name).size(), 500U) << group << name;
    }
  }
  const auto t = trace.read("t_ns");
  for (std::size_t k = 0; k < 500; ++k) ASSERT_EQ(t[k], double(k) * double(period_ns));
}

TEST_F(TraceRecorderTest, SaysWhichFileCannotBeCreatedAndWhy) {
  try {
    TraceRecorder{folder_ / "missing" / "trace.h5", {}, origin};
    FAIL() << "accepted";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("missing/trace.h5: cannot record a trace: "));
    EXPECT_THAT(e.what(), HasSubstr("No such file or directory"));
  }
}

TEST_F(TraceRecorderTest, RefusesParametersThatMakeNoSense) {
  for (const double interval_us : {0.0, -1.0, 10.0, 60.0, 1e10, std::nan(""), HUGE_VAL}) {
    SCOPED_TRACE(interval_us);
    EXPECT_THROW((TraceRecorder{file_, {.interval_us = interval_us}, origin}), std::runtime_error);
  }
  for (const int compression : {-1, 10}) {
    EXPECT_THROW((TraceRecorder{file_, {.compression = compression}, origin}), std::runtime_error);
  }
  EXPECT_THROW((TraceRecorder{file_, {}, {.scenario = "x", .control_period_ns = 0}}), std::runtime_error);
  const TraceOrigin exact{.scenario = "x", .control_period_ns = {}};
  EXPECT_THROW((TraceRecorder{file_, {.interval_us = 1e-4}, exact}), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(TraceRecorderTest, ReplacesAnOldTrace) {
  {
    TraceRecorder recorder{file_, {.interval_us = 25}, origin};
    record(recorder, 0, 500);
  }
  {
    TraceRecorder recorder{file_, {.interval_us = 25}, origin};
    record(recorder, 0, 3);
  }
  EXPECT_EQ(TraceFile{file_}.read("t_ns").size(), 3U);
}

TEST_F(TraceRecorderTest, CanBeMovedWhileItRecords) {
  TraceRecorder first{file_, {.interval_us = 25}, origin};
  record(first, 0, 5);
  TraceRecorder second{std::move(first)};
  record(second, 5, 10);
  second.close();
  EXPECT_EQ(TraceFile{file_}.read("t_ns").size(), 10U);
}

}  // namespace
}  // namespace sextant
