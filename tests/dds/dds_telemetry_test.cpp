#include "sextant/dds/dds_telemetry.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dds/topic_reader.hpp"
#include "support/allocation_counter.hpp"
#include "support/dds_domain.hpp"
#include "support/source_directory.hpp"
#include "telemetry.h"

namespace sextant {
namespace {

using namespace std::chrono_literals;
using testing::allocations;
using testing::dds_domain;
using testing::loopback_configuration;
template <class Sample>
using Reader = testing::TopicReader<Sample>;

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
  ASSERT_EQ(telemetry_.write(some_record(), std::uint64_t{1} << 40U), DdsWrite::ok);
  const auto next = reader.take();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->sequence, 1U);
  EXPECT_EQ(next->dropped, std::numeric_limits<std::uint32_t>::max()) << "the count ends there";
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
  std::vector<double TelemetryIntervalRecord<double>::*> members;
  const auto collect = [&members]<class Member>(Member TelemetryIntervalRecord<double>::* member) {
    if constexpr (std::is_same_v<Member, double>) members.push_back(member);
  };
#define SEXTANT_COLLECT(member, unit, text) collect(&TelemetryIntervalRecord<double>::member);
  SEXTANT_TELEMETRY_MEMBERS(SEXTANT_COLLECT)
#undef SEXTANT_COLLECT
  EXPECT_GE(members.size(), 19U);
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
  stages.push_max_us = std::numeric_limits<double>::infinity();
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

TEST_F(DdsTelemetryTest, PublishesAWaveformAsItIs) {
  Reader<sextant_DriveWaveform> reader{domain, sextant_DriveWaveform_desc, "sextant/DriveWaveform",
                                       DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE};
  for (int i = 0; i < 60'000 && telemetry_.waveform_readers() == 0; ++i) std::this_thread::sleep_for(1ms);
  ASSERT_EQ(telemetry_.waveform_readers(), 1U);
  EXPECT_EQ(telemetry_.readers(), 0U) << "of DriveTelemetry";
  WaveformBatch batch{.t_ns = 5, .period_ns = 25'000};
  for (unsigned k = 0; k < 400; ++k) {
    batch.offset_ns.push_back(k * 25'000U);
    batch.torque_nm.push_back(k == 7 ? std::numeric_limits<float>::quiet_NaN() : 0.5F * float(k));
    batch.duty_c.push_back(float(k));
    batch.state.push_back(std::uint8_t(k % 8));
  }
  ASSERT_EQ(telemetry_.write(batch, 1ULL << 40U, 9), DdsWrite::ok);
  auto s = reader.take();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->drive_id, 42U);
  EXPECT_EQ(s->sequence, 9U);
  EXPECT_EQ(s->dropped, 1ULL << 40U);
  EXPECT_EQ(s->t_ns, 5);
  ASSERT_EQ(s->offset_ns._length, 400U);
  ASSERT_EQ(s->torque_nm._length, 400U);
  EXPECT_EQ(s->i_a_a._length, 0U);
  EXPECT_EQ(s->offset_ns._buffer[399], 399U * 25'000U);
  EXPECT_TRUE(std::isnan(s->torque_nm._buffer[7]));
  EXPECT_EQ(s->torque_nm._buffer[8], 4.0F);
  EXPECT_EQ(s->duty_c._buffer[399], 399.0F);
  EXPECT_EQ(s->state._buffer[9], 1U);
  dds_sample_free(&*s, &sextant_DriveWaveform_desc, DDS_FREE_CONTENTS);
}

TEST_F(DdsTelemetryTest, LateJoinerGetsTheNewestState) {
  DriveStateSample sample{.t_ns = 1, .state = DriveState::ready, .lockout = false, .reason = "disable seen"};
  ASSERT_EQ(telemetry_.write(sample), DdsWrite::ok);
  sample.t_ns = 2;
  sample.state = DriveState::fault;
  sample.faults_latched.set(Fault::over_current);
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

TEST_F(DdsTelemetryTest, PublishesEveryMemberOfTheStatistics) {
  RealTimeSample sample{.wait = WaitMode::hybrid,
                        .policy = SchedulingPolicy::deadline,
                        .real_time_scheduling = true,
                        .memory_locked = true};
  // Each number its own, so that no two members can be confused.
  int value = 0;
  const auto set = [&value]<class Member>(Member& member) {
    if constexpr (std::is_arithmetic_v<Member> && !std::is_same_v<Member, bool>) member = Member(++value);
  };
#define SEXTANT_SET(member, unit, text) set(sample.member);
  SEXTANT_REAL_TIME_MEMBERS(SEXTANT_SET)
#undef SEXTANT_SET
  EXPECT_GT(value, 40);
  ASSERT_EQ(telemetry_.write(sample), DdsWrite::ok);
  Reader<sextant_RealTimeStatistics> reader(domain, sextant_RealTimeStatistics_desc,
                                            "sextant/RealTimeStatistics", DDS_RELIABILITY_RELIABLE,
                                            DDS_DURABILITY_TRANSIENT_LOCAL);
  const auto s = reader.take();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->drive_id, 42U);
  EXPECT_EQ(s->wait, sextant_HYBRID);
  EXPECT_EQ(s->policy, sextant_DEADLINE);
#define SEXTANT_EXPECT(member, unit, text) EXPECT_EQ(double(s->member), double(sample.member)) << #member;
  SEXTANT_REAL_TIME_MEMBERS(SEXTANT_EXPECT)
#undef SEXTANT_EXPECT
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
