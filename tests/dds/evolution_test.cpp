#include <chrono>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

#include "dds/topic_reader.hpp"
#include "earlier_telemetry.h"
#include "sextant/dds/dds_telemetry.hpp"
#include "support/dds_domain.hpp"
#include "telemetry.h"

// earlier_telemetry.idl is the contract without the last member of each struct.

namespace sextant {
namespace {

using testing::dds_domain;
using testing::loopback_configuration;
using testing::TopicReader;

template <class Sample>
TopicReader<Sample> latched_reader(std::uint32_t domain, const dds_topic_descriptor_t& type,
                                   const char* topic) {
  return {domain, type, topic, DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL};
}

TEST(TelemetryEvolution, AReaderOfAnEarlierContractReadsEveryTopic) {
  const std::uint32_t domain = dds_domain(20);
  DdsTelemetry telemetry({.domain_id = domain, .drive_id = 42, .configuration = loopback_configuration()});
  TopicReader<earlier_DriveTelemetry> intervals{domain, earlier_DriveTelemetry_desc, "sextant/DriveTelemetry",
                                                DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE};
  for (int i = 0; i < 60'000 && telemetry.readers() == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  ASSERT_EQ(telemetry.write(
                TelemetryIntervalRecord<double>{
                    .t_ns = 7, .power_w = 8.0, .command_counter = 9, .command_received_ns = 10},
                0),
            DdsWrite::ok);
  const auto interval = intervals.take();
  ASSERT_TRUE(interval);
  EXPECT_EQ(interval->drive_id, 42U);
  EXPECT_EQ(interval->t_ns, 7);
  EXPECT_EQ(interval->power_w, 8.0F);
  EXPECT_EQ(interval->command_counter, 9);

  ASSERT_EQ(telemetry.write(DriveStateSample{.t_ns = 11, .fault_total = 12, .reason = "because"}),
            DdsWrite::ok);
  const auto state =
      latched_reader<earlier_DriveState>(domain, earlier_DriveState_desc, "sextant/DriveState").take();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->t_ns, 11);
  EXPECT_EQ(state->fault_total, 12U);

  ASSERT_EQ(telemetry.write(RealTimeSample{.t_ns = 13, .real_time_scheduling = true, .memory_locked = true}),
            DdsWrite::ok);
  const auto statistics = latched_reader<earlier_RealTimeStatistics>(domain, earlier_RealTimeStatistics_desc,
                                                                     "sextant/RealTimeStatistics")
                              .take();
  ASSERT_TRUE(statistics);
  EXPECT_EQ(statistics->t_ns, 13);
  EXPECT_TRUE(statistics->real_time_scheduling);
}

/// Writes a sample as an earlier version of the drive would, and lets `read` take it.
template <class Sample, class Read>
void with_earlier_writer(std::uint32_t domain, const dds_topic_descriptor_t& type, const char* topic,
                         const Sample& sample, Read&& read) {
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_entity_t writer = dds_create_writer(
      participant, dds_create_topic(participant, &type, topic, nullptr, nullptr), qos, nullptr);
  dds_delete_qos(qos);
  EXPECT_EQ(dds_write(writer, &sample), DDS_RETCODE_OK);
  read();
  dds_delete(participant);
}

TEST(TelemetryEvolution, AReaderFindsZeroWhereAnEarlierWriterHasNoMember) {
  const std::uint32_t domain = dds_domain(20);
  const dds_entity_t configured = dds_create_domain(domain, loopback_configuration().c_str());
  earlier_DriveTelemetry interval{};
  interval.t_ns = 7;
  interval.command_counter = 9;
  with_earlier_writer(domain, earlier_DriveTelemetry_desc, "sextant/DriveTelemetry", interval, [domain] {
    const auto s =
        latched_reader<sextant_DriveTelemetry>(domain, sextant_DriveTelemetry_desc, "sextant/DriveTelemetry")
            .take();
    ASSERT_TRUE(s);
    EXPECT_EQ(s->t_ns, 7);
    EXPECT_EQ(s->command_counter, 9);
    EXPECT_EQ(s->command_received_ns, 0);
  });
  earlier_DriveState state{};
  state.t_ns = 11;
  state.fault_total = 12;
  with_earlier_writer(domain, earlier_DriveState_desc, "sextant/DriveState", state, [domain] {
    const auto s =
        latched_reader<sextant_DriveState>(domain, sextant_DriveState_desc, "sextant/DriveState").take();
    ASSERT_TRUE(s);
    EXPECT_EQ(s->t_ns, 11);
    EXPECT_EQ(s->fault_total, 12U);
    EXPECT_STREQ(s->reason, "");
  });
  earlier_RealTimeStatistics statistics{};
  statistics.t_ns = 13;
  statistics.real_time_scheduling = true;
  with_earlier_writer(
      domain, earlier_RealTimeStatistics_desc, "sextant/RealTimeStatistics", statistics, [domain] {
        const auto s = latched_reader<sextant_RealTimeStatistics>(domain, sextant_RealTimeStatistics_desc,
                                                                  "sextant/RealTimeStatistics")
                           .take();
        ASSERT_TRUE(s);
        EXPECT_EQ(s->t_ns, 13);
        EXPECT_TRUE(s->real_time_scheduling);
        EXPECT_FALSE(s->memory_locked);
      });
  dds_delete(configured);
}

}  // namespace
}  // namespace sextant
