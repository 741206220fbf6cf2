#include "ecu/telemetry_thread.hpp"

#include <string>

#include <gtest/gtest.h>

#include "ecu/eventually.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "support/dds_domain.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// On its own domain, within this machine.
DdsTelemetry::Parameters dds_parameters() {
  return {.domain_id = testing::dds_domain(30),
          .configuration = "file://" SEXTANT_SOURCE_DIR "/configs/cyclonedds_loopback.xml"};
}

// The topic's rate is configured; the CAN signals are those of the last second whatever it is.
TEST(DdsTelemetryThread, CanIsToldTheWorstOfASecondWhateverTheRateOfTheStatistics) {
  for (const std::int64_t statistics_ns : {10 * ms, 100'000 * ms}) {
    SCOPED_TRACE(statistics_ns);
    Crossings crossings{25'000, 1};
    DdsTelemetry dds{dds_parameters()};
    TelemetryThread telemetry{{.statistics_ns = statistics_ns}, dds, crossings};
    telemetry.start();
    const std::int64_t begin_ns = now_ns() + 100 * ms;
    for (int k = 0; k <= 1000; ++k) {
      crossings.wakes.push({.deadline_ns = begin_ns + k * ms,
                            .latency_ns = k == 100 ? 7 * ms : k,
                            .body_ns = k == 200 ? 5 * ms : k,
                            .periods_skipped = std::uint64_t(k)});
    }
    EXPECT_TRUE(test::eventually([&] { return crossings.statistics.latest().worst_body_ns != 0; }));
    EXPECT_EQ(crossings.statistics.value().worst_body_ns, 5 * ms);
    EXPECT_EQ(crossings.statistics.value().worst_latency_ns, 7 * ms);
    crossings.stopped.store(true);
    telemetry.join();
  }
}

// The kernel's word of a stop is in the sample that was taken after it; the next sample knows nothing of it.
TEST(DdsTelemetryThread, AMissThatWaitsInTheRingIsJudgedByTheSampleThatSawIt) {
  Crossings crossings{25'000, 1};
  DdsTelemetry dds{dds_parameters()};
  TelemetryThread telemetry{{}, dds, crossings};
  crossings.wakes.push({.deadline_ns = ms,
                        .latency_ns = ms,
                        .overrun = true,
                        .body_overran = true,
                        .gap = {ms, GapPlace::read, ms},
                        .longest_gap_ns = ms});
  crossings.scheduler.store({.t_ns = 50 * ms, .run_delay_ns = ms, .involuntary_switches = 1, .valid = true});
  crossings.stopped.store(true);
  telemetry.start();
  telemetry.join();
  EXPECT_EQ(telemetry.timing().causes()[static_cast<std::size_t>(MissCause::machine_gap)], 1U);
}

}  // namespace
}  // namespace sextant::ecu
