#include "sextant/dds/dds_telemetry.hpp"

#include <chrono>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/allocation_counter.hpp"
#include "support/dds_domain.hpp"
#include "telemetry.h"

namespace sextant {
namespace {

using namespace std::chrono_literals;
using testing::allocations;
using testing::dds_domain;

std::string loopback_configuration() {
  std::ifstream file(SEXTANT_SOURCE_DIR "/configs/cyclonedds_loopback.xml");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Samples of one topic, read as any C program would.
template <class Sample>
class Reader {
 public:
  Reader(std::uint32_t domain, const dds_topic_descriptor_t& type, const char* topic,
         dds_reliability_kind_t reliability, dds_durability_kind_t durability)
      : participant_(dds_create_participant(domain, nullptr, nullptr)) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, reliability, DDS_SECS(1));
    dds_qset_durability(qos, durability);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    reader_ = dds_create_reader(participant_, dds_create_topic(participant_, &type, topic, nullptr, nullptr),
                                qos, nullptr);
    dds_delete_qos(qos);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { dds_delete(participant_); }

  /// The next sample; nothing when none comes within a minute.
  std::optional<Sample> take() {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    do {
      Sample sample{};
      void* samples[] = {&sample};
      dds_sample_info_t info{};
      if (dds_take(reader_, samples, &info, 1, 1) == 1 && info.valid_data) return sample;
      std::this_thread::sleep_for(1ms);
    } while (std::chrono::steady_clock::now() < deadline);
    return {};
  }

 private:
  dds_entity_t participant_;
  dds_entity_t reader_{0};
};

Reader<sextant_DriveTelemetry> telemetry_reader(std::uint32_t domain) {
  return {domain, sextant_DriveTelemetry_desc, "sextant/DriveTelemetry", DDS_RELIABILITY_BEST_EFFORT,
          DDS_DURABILITY_VOLATILE};
}

Reader<sextant_DriveState> state_reader(std::uint32_t domain) {
  return {domain, sextant_DriveState_desc, "sextant/DriveState", DDS_RELIABILITY_RELIABLE,
          DDS_DURABILITY_TRANSIENT_LOCAL};
}

class DdsTelemetryTest : public ::testing::Test {
 protected:
  void wait_for_reader() {
    for (int i = 0; i < 60'000 && telemetry_.readers() == 0; ++i) std::this_thread::sleep_for(1ms);
    ASSERT_EQ(telemetry_.readers(), 1U);
  }

  const std::uint32_t domain{dds_domain(10)};
  DdsTelemetry telemetry_{{.domain_id = domain, .drive_id = 42, .configuration = loopback_configuration()}};
};

TelemetryIntervalRecord<double> some_record() {
  TelemetryIntervalRecord<double> r;
  r.t_ns = 123;
  r.periods = 40;
  // Each value its own, so that no two members can be confused.
  double* const first = &r.torque_requested_nm;
  double* const last = &r.power_w;
  double value = 1.5;
  for (double* p = first; p <= last; ++p) *p = value++;
  r.state = DriveState::torque;
  r.sector = 5;
  r.command_counter = 14;
  r.command_received_ns = 99;
  return r;
}

TEST_F(DdsTelemetryTest, PublishesEveryMemberOfAnInterval) {
  auto reader = telemetry_reader(domain);
  wait_for_reader();
  ASSERT_EQ(telemetry_.write(some_record(), 3), DdsWrite::ok);
  const auto s = reader.take();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->drive_id, 42U);
  EXPECT_EQ(s->sequence, 0U);
  EXPECT_EQ(s->t_ns, 123);
  EXPECT_EQ(s->periods, 40U);
  EXPECT_EQ(s->dropped, 3U);
  const float got[] = {s->torque_requested_nm,
                       s->torque_reference_nm,
                       s->torque_mean_nm,
                       s->torque_min_nm,
                       s->torque_max_nm,
                       s->flux_mean_wb,
                       s->flux_min_wb,
                       s->flux_max_wb,
                       s->current_mean_a,
                       s->current_min_a,
                       s->current_max_a,
                       s->i_a_a,
                       s->i_b_a,
                       s->i_c_a,
                       s->flux_angle_rad,
                       s->speed_rad_s,
                       s->u_dc_v,
                       s->i_dc_a,
                       s->power_w};
  float value = 1.5F;
  for (const float x : got) EXPECT_EQ(x, value++);
  EXPECT_EQ(s->state, sextant_TORQUE);
  EXPECT_EQ(s->sector, 5);
  EXPECT_EQ(s->command_counter, 14);
  EXPECT_EQ(s->command_received_ns, 99);
  ASSERT_EQ(telemetry_.write(some_record(), 3), DdsWrite::ok);
  EXPECT_EQ(reader.take().value().sequence, 1U);
}

TEST_F(DdsTelemetryTest, NumbersSamplesAsItIsTold) {
  auto reader = telemetry_reader(domain);
  wait_for_reader();
  ASSERT_EQ(telemetry_.write(some_record(), 0, 17), DdsWrite::ok);
  EXPECT_EQ(reader.take().value().sequence, 17U);
  ASSERT_EQ(telemetry_.write(some_record(), 0), DdsWrite::ok);
  EXPECT_EQ(reader.take().value().sequence, 18U);
}

// What remains after a reader's declaration has ended the process once.
TEST(DdsTelemetry, WithoutTypeInformationAReaderThatKnowsTheTypeReads) {
  const std::uint32_t domain = dds_domain(20);
  DdsTelemetry telemetry({.domain_id = domain,
                          .drive_id = 42,
                          .configuration = loopback_configuration(),
                          .type_information = false});
  ASSERT_EQ(telemetry.write(DriveStateSample{.t_ns = 3, .reason = "because"}), DdsWrite::ok);
  const auto s = state_reader(domain).take();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->t_ns, 3);
  EXPECT_STREQ(s->reason, "because");
}

TEST_F(DdsTelemetryTest, RefusesNaNAndInfinityInEveryMember) {
  auto reader = telemetry_reader(domain);
  wait_for_reader();
  constexpr double TelemetryIntervalRecord<double>::* members[] = {
      &TelemetryIntervalRecord<double>::torque_requested_nm,
      &TelemetryIntervalRecord<double>::torque_reference_nm,
      &TelemetryIntervalRecord<double>::torque_mean_nm,
      &TelemetryIntervalRecord<double>::torque_min_nm,
      &TelemetryIntervalRecord<double>::torque_max_nm,
      &TelemetryIntervalRecord<double>::flux_mean_wb,
      &TelemetryIntervalRecord<double>::flux_min_wb,
      &TelemetryIntervalRecord<double>::flux_max_wb,
      &TelemetryIntervalRecord<double>::current_mean_a,
      &TelemetryIntervalRecord<double>::current_min_a,
      &TelemetryIntervalRecord<double>::current_max_a,
      &TelemetryIntervalRecord<double>::i_a_a,
      &TelemetryIntervalRecord<double>::i_b_a,
      &TelemetryIntervalRecord<double>::i_c_a,
      &TelemetryIntervalRecord<double>::flux_angle_rad,
      &TelemetryIntervalRecord<double>::speed_rad_s,
      &TelemetryIntervalRecord<double>::u_dc_v,
      &TelemetryIntervalRecord<double>::i_dc_a,
      &TelemetryIntervalRecord<double>::power_w};
  std::uint64_t refused = 0;
  for (const auto member : members) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity(), 1e300}) {
      TelemetryIntervalRecord<double> record = some_record();
      record.*member = bad;
      EXPECT_EQ(telemetry_.write(record, 0), DdsWrite::refused);
      EXPECT_EQ(telemetry_.counts().refused, ++refused);
    }
  }
  RealTimeSample statistics;
  statistics.execution_max_us = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(telemetry_.write(statistics), DdsWrite::refused);
  RealTimeSample stages;
  stages.stages.back().max_us = std::numeric_limits<double>::infinity();
  EXPECT_EQ(telemetry_.write(stages), DdsWrite::refused);
  ASSERT_EQ(telemetry_.write(some_record(), 0), DdsWrite::ok);
  EXPECT_EQ(reader.take().value().sequence, refused);  // the first that was published; the gap tells of them
}

TEST_F(DdsTelemetryTest, WritesIntervalsWithoutAllocating) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  auto reader = telemetry_reader(domain);
  wait_for_reader();
  const TelemetryIntervalRecord<double> record = some_record();
  for (int i = 0; i < 100; ++i) (void)telemetry_.write(record, 0);
  const std::uint64_t before = allocations();
  for (int i = 0; i < 10'000; ++i) (void)telemetry_.write(record, 0);
  EXPECT_EQ(allocations(), before);
  // The counter itself counts.
  const std::string on_the_heap(1000, 'x');
  EXPECT_GT(allocations(), before);
}

TEST_F(DdsTelemetryTest, LateJoinerGetsTheNewestState) {
  DriveStateSample sample{.t_ns = 1, .state = DriveState::ready, .lockout = false, .reason = "disable seen"};
  ASSERT_EQ(telemetry_.write(sample), DdsWrite::ok);
  sample.t_ns = 2;
  sample.state = DriveState::fault;
  sample.latched.set(Fault::over_current);
  sample.first_fault = Fault::over_current;
  sample.fault_total = 1;
  const std::string reason(100, 'x');
  sample.reason = reason;
  ASSERT_EQ(telemetry_.write(sample), DdsWrite::ok);

  auto reader = state_reader(domain);
  const auto s = reader.take();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->drive_id, 42U);
  EXPECT_EQ(s->t_ns, 2);
  EXPECT_EQ(s->sequence, 1U);
  EXPECT_EQ(s->state, sextant_FAULT);
  EXPECT_FALSE(s->lockout);
  EXPECT_EQ(s->faults_latched, 1U << 8U);
  EXPECT_EQ(s->first_fault, 8);
  EXPECT_EQ(s->fault_total, 1U);
  EXPECT_EQ(std::string(s->reason), std::string(64, 'x'));
}

TEST_F(DdsTelemetryTest, CutsTheReasonBetweenCharacters) {
  const std::string reason = std::string(63, 'x') + "µ";
  ASSERT_EQ(telemetry_.write(DriveStateSample{.reason = reason}), DdsWrite::ok);
  EXPECT_EQ(std::string(state_reader(domain).take().value().reason), std::string(63, 'x'));
}

TEST_F(DdsTelemetryTest, PublishesStatistics) {
  ASSERT_EQ(telemetry_.write(RealTimeSample{
                .t_ns = 5,
                .period_ns = 25'000,
                .wake_every_periods = 40,
                .wait = WaitMode::hybrid,
                .policy = SchedulingPolicy::deadline,
                .periods = 40'000,
                .periods_missed = 3,
                .overruns = 2,
                .overruns_by_cause = {21, 22, 23, 24},
                .overruns_without_gap = 25,
                .gaps = 26,
                .longest_gap_us = 27.0,
                .wake_latency_p50_us = 1.0,
                .wake_latency_p99_us = 2.0,
                .wake_latency_p99_9_us = 2.1,
                .wake_latency_p99_99_us = 2.2,
                .wake_latency_max_us = 3.0,
                .execution_p50_us = 4.0,
                .execution_p99_us = 5.0,
                .execution_p99_9_us = 5.1,
                .execution_p99_99_us = 5.2,
                .execution_max_us = 6.0,
                .stages = {StageFigures{31, 32, 33}, {34, 35, 36}, {37, 38, 39}, {40, 41, 42}, {43, 44, 45}},
                .page_faults = 51,
                .voluntary_switches = 52,
                .involuntary_switches = 53,
                .run_delay_us = 54.0,
                .steal_us = 55.0,
                .telemetry_dropped = 7,
                .commands_received = 8,
                .commands_rejected = 9,
                .real_time_scheduling = true,
                .memory_locked = true}),
            DdsWrite::ok);
  Reader<sextant_RealTimeStatistics> reader(domain, sextant_RealTimeStatistics_desc,
                                            "sextant/RealTimeStatistics", DDS_RELIABILITY_RELIABLE,
                                            DDS_DURABILITY_TRANSIENT_LOCAL);
  const auto s = reader.take();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->period_ns, 25'000U);
  EXPECT_EQ(s->wake_every_periods, 40U);
  EXPECT_EQ(s->periods, 40'000U);
  EXPECT_EQ(s->periods_missed, 3U);
  EXPECT_EQ(s->overruns, 2U);
  EXPECT_EQ(s->wake_latency_max_us, 3.0);
  EXPECT_EQ(s->execution_p50_us, 4.0);
  EXPECT_EQ(s->execution_max_us, 6.0);
  EXPECT_EQ(s->wait, sextant_HYBRID);
  EXPECT_EQ(s->policy, sextant_DEADLINE);
  EXPECT_EQ(s->overruns_machine, 21U);
  EXPECT_EQ(s->overruns_stage_gap, 22U);
  EXPECT_EQ(s->overruns_late_wake, 23U);
  EXPECT_EQ(s->overruns_own_execution, 24U);
  EXPECT_EQ(s->overruns_without_gap, 25U);
  EXPECT_EQ(s->gaps, 26U);
  EXPECT_EQ(s->longest_gap_us, 27.0);
  EXPECT_EQ(s->wake_latency_p99_9_us, 2.1);
  EXPECT_EQ(s->wake_latency_p99_99_us, 2.2);
  EXPECT_EQ(s->execution_p99_9_us, 5.1);
  EXPECT_EQ(s->execution_p99_99_us, 5.2);
  EXPECT_EQ(
      (std::array{s->read_p50_us, s->commands_p99_9_us, s->drive_max_us, s->write_p50_us, s->push_max_us}),
      (std::array{31.0, 35.0, 39.0, 40.0, 45.0}));
  EXPECT_EQ(s->page_faults, 51U);
  EXPECT_EQ(s->voluntary_switches, 52U);
  EXPECT_EQ(s->involuntary_switches, 53U);
  EXPECT_EQ(s->run_delay_us, 54.0);
  EXPECT_EQ(s->steal_us, 55.0);
  EXPECT_EQ(s->telemetry_dropped, 7U);
  EXPECT_EQ(s->commands_received, 8U);
  EXPECT_EQ(s->commands_rejected, 9U);
  EXPECT_TRUE(s->real_time_scheduling && s->memory_locked);
}

TEST_F(DdsTelemetryTest, SeesAReaderThatAsksForMoreThanIsOffered) {
  EXPECT_EQ(telemetry_.incompatible_readers(), 0U);
  const Reader<sextant_DriveTelemetry> reliable(domain, sextant_DriveTelemetry_desc, "sextant/DriveTelemetry",
                                                DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_VOLATILE);
  for (int i = 0; i < 60'000 && telemetry_.incompatible_readers() == 0; ++i) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(telemetry_.incompatible_readers(), 1U);
  EXPECT_EQ(telemetry_.readers(), 0U);
}

TEST_F(DdsTelemetryTest, AReaderThatStoppedDoesNotBlockTheWriter) {
  auto reader = state_reader(domain);
  for (int i = 0; i < 2000; ++i) {
    ASSERT_EQ(telemetry_.write(DriveStateSample{.t_ns = i}), DdsWrite::ok);
  }
  EXPECT_EQ(telemetry_.counts().written, 2000U);
  EXPECT_EQ(telemetry_.counts().failed, 0U);
}

TEST_F(DdsTelemetryTest, ManyDrivesOfOneProcessAreInstancesOfOneTopic) {
  constexpr std::uint32_t drives = 64;
  auto reader = telemetry_reader(domain);
  wait_for_reader();
  std::vector<std::unique_ptr<DdsTelemetry>> others;
  for (std::uint32_t id = 100; id < 100 + drives; ++id) {
    others.push_back(std::make_unique<DdsTelemetry>(telemetry_, id));
  }
  for (int i = 0; i < 60'000 && others.back()->readers() == 0; ++i) std::this_thread::sleep_for(1ms);
  // KEEP_LAST 1 is by instance: were they one, only the last of each round would be left.
  for (int round = 0; round < 3; ++round) {
    for (const auto& other : others) ASSERT_EQ(other->write(some_record(), 0), DdsWrite::ok);
  }
  std::map<std::uint32_t, std::uint64_t> newest;
  for (std::uint32_t n = 0; n < drives; ++n) {
    const auto s = reader.take();
    ASSERT_TRUE(s) << "only " << n << " drives were seen";
    newest[s->drive_id] = s->sequence;
  }
  ASSERT_EQ(newest.size(), drives);
  for (const auto& [id, sequence] : newest) EXPECT_EQ(sequence, 2U) << "drive " << id;
  for (const auto& other : others) EXPECT_EQ(other->counts().written, 3U);
  EXPECT_EQ(telemetry_.counts().written, 0U);
}

TEST(DdsTelemetry, ASharedParticipantOutlivesItsFirstDrive) {
  const std::uint32_t domain = dds_domain(20);
  auto first = std::make_unique<DdsTelemetry>(
      DdsTelemetry::Parameters{.domain_id = domain, .configuration = loopback_configuration()});
  DdsTelemetry second(*first, 2);
  first.reset();
  auto reader = telemetry_reader(domain);
  for (int i = 0; i < 60'000 && second.readers() == 0; ++i) std::this_thread::sleep_for(1ms);
  ASSERT_EQ(second.write(some_record(), 0), DdsWrite::ok);
  EXPECT_EQ(reader.take().value().drive_id, 2U);
  EXPECT_NO_THROW(DdsTelemetry(second, 1)) << "the id of a drive that ended is free again";
}

TEST(DdsTelemetry, RefusesASecondDriveOfTheSameId) {
  const DdsTelemetry first(
      {.domain_id = dds_domain(20), .drive_id = 7, .configuration = loopback_configuration()});
  try {
    const DdsTelemetry second(first, 7);
    FAIL() << "two writers of one key";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("already publishes a drive with the id 7"));
  }
}

std::string refusal(const DdsTelemetry::Parameters& parameters) {
  try {
    const DdsTelemetry telemetry(parameters);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(DdsTelemetry, SaysInOneSentenceWhyItCannotStart) {
  for (const char* const configuration :
       {"<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>", "file:///no/such/file.xml",
        "<CycloneDDS><Domain><General><Interfaces><NetworkInterface "
        "name=\"no_such_nic\"/></Interfaces></General>"
        "</Domain></CycloneDDS>"}) {
    const std::string text = refusal({.domain_id = 88, .configuration = configuration});
    EXPECT_THAT(text, ::testing::StartsWith("DDS cannot start on domain 88: ")) << configuration;
    EXPECT_EQ(text.find('\n'), std::string::npos);
  }
  EXPECT_THAT(refusal({.domain_id = 231}), ::testing::HasSubstr("from 0 to 230"));
}

TEST(DdsTelemetry, RefusesAConfigurationThatIsNotClosed) {
  const std::string text = refusal({.domain_id = 88, .configuration = "<CycloneDDS><Domain>"});
  EXPECT_THAT(text, ::testing::StartsWith("DDS cannot start on domain 88: "));
  EXPECT_THAT(text, ::testing::HasSubstr("<Domain> is not closed"));
}

TEST(DdsTelemetry, SaysWhereAConfigurationThatWasRefusedComesFrom) {
  EXPECT_THAT(refusal({.domain_id = 88,
                       .configuration = "file:///no/such/file.xml",
                       .configuration_source = "CYCLONEDDS_URI"}),
              ::testing::EndsWith("; the configuration comes from CYCLONEDDS_URI"));
}

TEST(DdsTelemetry, RefusesASecondConfigurationOfARunningDomain) {
  const DdsTelemetry::Parameters parameters{.domain_id = dds_domain(20),
                                            .configuration = loopback_configuration()};
  const DdsTelemetry first(parameters);
  EXPECT_THAT(refusal(parameters), ::testing::HasSubstr("already runs in this process"));
}

}  // namespace
}  // namespace sextant
