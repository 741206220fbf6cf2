#include "ecu/tasks/telemetry_task.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "comms/command_frames.hpp"
#include "ecu/tasks/receive_task.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// The newest DriveState that has arrived at the other end; nothing where none has.
std::optional<StateMessage> newest_state(MessageSocket& socket) {
  std::optional<StateMessage> newest;
  std::array<std::byte, 4096> buffer{};
  while (const auto message = socket.receive(buffer)) {
    if (kind_of(*message) == TelemetryMessageKind::state) newest = content_of<StateMessage>(*message);
  }
  return newest;
}

// The topic's rate is configured; the CAN signals are those of the last second whatever it is.
TEST(TelemetryTask, CanIsToldTheWorstOfASecondWhateverTheRateOfTheStatistics) {
  for (const std::int64_t statistics_ns : {10 * ms, 100'000 * ms}) {
    SCOPED_TRACE(statistics_ns);
    SharedState shared{25'000, 1};
    TelemetrySender sender;
    TelemetryTask telemetry{{.statistics_ns = statistics_ns}, sender, shared};
    telemetry.start(0, {});
    const std::int64_t begin_ns = 100 * ms;
    for (int k = 0; k <= 1000; ++k) {
      shared.wakes.push({.deadline_ns = begin_ns + k * ms,
                         .latency_ns = k == 100 ? 7 * ms : k,
                         .execution_ns = k == 200 ? 5 * ms : k,
                         .periods_missed = std::uint64_t(k)});
    }
    telemetry.poll(begin_ns + 1000 * ms);
    ASSERT_TRUE(shared.real_time.update());
    EXPECT_DOUBLE_EQ(shared.real_time.value().worst_execution_time, 5e-3);
    EXPECT_DOUBLE_EQ(shared.real_time.value().worst_wake_latency, 7e-3);
  }
}

// The kernel's word of a stop is in the sample that was taken after it; the next sample knows nothing of it.
TEST(TelemetryTask, AnOverrunThatWaitsInTheRingIsEvaluatedByTheSampleAfterIt) {
  SharedState shared{25'000, 1};
  TelemetrySender sender;
  TelemetryTask telemetry{{}, sender, shared};
  shared.wakes.push({.deadline_ns = ms,
                     .latency_ns = ms,
                     .overrun = true,
                     .execution_overran = true,
                     .gap = {ms, GapPlace::read, ms},
                     .longest_gap_ns = ms});
  shared.scheduler.store({.t_ns = 50 * ms, .run_delay_ns = ms, .involuntary_switches = 1, .valid = true});
  telemetry.start(0, {});
  telemetry.finish();
  EXPECT_EQ(telemetry.timing().causes()[static_cast<std::size_t>(OverrunCause::machine_gap)], 1U);
}

// The drive says nothing more, so that what it said last would stand for ever.
TEST(TelemetryTask, ATimedOutControlThreadIsPublishedInThePlaceOfTheDrive) {
  constexpr std::int64_t limit_ns = 100 * ms;
  SharedState shared{25'000, 1, limit_ns};
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  TelemetryTask telemetry{{}, sender, shared};
  const std::int64_t beat_ns = 1'000 * ms;
  shared.beat(beat_ns);
  Telemetry<double> record;
  record.t_ns = beat_ns;
  record.state = DriveState::torque;
  shared.telemetry.push(record);

  telemetry.poll(beat_ns + limit_ns);
  auto told = newest_state(other);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->sample().state, DriveState::torque);

  telemetry.poll(beat_ns + limit_ns + ms);
  told = newest_state(other);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->sample().state, DriveState::fault);
  EXPECT_EQ(told->sample().first_fault, Fault::watchdog);
  EXPECT_EQ(told->sample().t_ns, beat_ns);
  EXPECT_EQ(told->sample().reason, "WATCHDOG: control thread without a wake-up for 101 ms");

  telemetry.poll(beat_ns + limit_ns + 1'000 * ms);
  told = newest_state(other);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->sample().reason, "WATCHDOG: control thread without a wake-up for 1100 ms");

  // It is back, and says itself what has become of it.
  shared.beat(beat_ns + limit_ns + 1'000 * ms);
  shared.telemetry.push(record);
  telemetry.poll(beat_ns + limit_ns + 1'001 * ms);
  told = newest_state(other);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->sample().state, DriveState::torque);
  EXPECT_EQ(told->sample().reason, "torque reference as requested");
}

/// A frame in the place of a good one with this counter, for the receiver to reject by this cause.
CanFrame wrong_frame(FrameVerdict cause, std::uint8_t counter) {
  CanFrame frame = testing::command_frame(counter, 5.0);
  const auto protected_again = [&frame](std::uint8_t other_counter) {
    testing::protect(frame, command_data_id(), other_counter);
    return frame;
  };
  switch (cause) {
    case FrameVerdict::wrong_length:
      frame.length = 7;
      return frame;
    case FrameVerdict::remote_frame:
      frame.rtr = true;
      return frame;
    case FrameVerdict::extended_alias:
      frame.extended = true;
      return frame;
    case FrameVerdict::fd_alias:
      frame.fd = true;
      return frame;
    case FrameVerdict::wrong_crc:
      frame.data[0] ^= 1U;
      return frame;
    case FrameVerdict::wrong_data_id: {
      frame.data[1] ^= 0xF0U;
      e2e::Data data{};
      std::copy_n(frame.data.begin(), data.size(), data.begin());
      frame.data[0] = e2e::crc(command_data_id(), data);
      return frame;
    }
    case FrameVerdict::invalid_counter:
      return protected_again(e2e::counter_modulus);
    case FrameVerdict::repeated:
      return protected_again(std::uint8_t((counter + e2e::counter_modulus - 1) % e2e::counter_modulus));
    case FrameVerdict::wrong_sequence:
      return protected_again(std::uint8_t((counter + 6) % e2e::counter_modulus));
    case FrameVerdict::out_of_range:
      frame.data[3] = 0x7F;  // about 326 N·m
      return protected_again(counter);
    default:
      return frame;
  }
}

struct CountedCause {
  FrameVerdict cause;
  std::uint64_t RealTimeSample::* count;
};

constexpr auto counted_causes = std::to_array<CountedCause>({
    {FrameVerdict::wrong_length, &RealTimeSample::rejected_wrong_length},
    {FrameVerdict::remote_frame, &RealTimeSample::rejected_remote_frame},
    {FrameVerdict::extended_alias, &RealTimeSample::rejected_extended_alias},
    {FrameVerdict::fd_alias, &RealTimeSample::rejected_fd_alias},
    {FrameVerdict::wrong_crc, &RealTimeSample::rejected_wrong_crc},
    {FrameVerdict::wrong_data_id, &RealTimeSample::rejected_wrong_data_id},
    {FrameVerdict::invalid_counter, &RealTimeSample::rejected_invalid_counter},
    {FrameVerdict::repeated, &RealTimeSample::rejected_repeated},
    {FrameVerdict::wrong_sequence, &RealTimeSample::rejected_wrong_sequence},
    {FrameVerdict::out_of_range, &RealTimeSample::rejected_out_of_range},
});

/// Sends three frames of the first cause, four of the second and so on, each behind so many good ones that
/// the stream is valid. Two good ones before it is are rejected too.
void send_every_cause(ReceiveTask& receive) {
  std::uint8_t counter = 0;
  const auto next = [&counter] { return counter = std::uint8_t((counter + 1) % e2e::counter_modulus); };
  std::uint64_t frames = 3;
  for (const CountedCause& counted : counted_causes) {
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
      for (int good = 0; good < 10; ++good) receive.on_frame(testing::command_frame(next(), 5.0));
      const CanFrame wrong = wrong_frame(counted.cause, std::uint8_t((counter + 1) % e2e::counter_modulus));
      receive.on_frame(wrong);
      if (counted.cause == FrameVerdict::wrong_sequence || counted.cause == FrameVerdict::out_of_range)
        counter = wrong.data[1] & 0x0FU;  // the stream goes on from it
    }
    ++frames;
  }
}

/// What the task's last message tells.
RealTimeSample statistics_of(SharedState& shared) {
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  TelemetryTask task{{}, sender, shared};
  task.finish();
  std::array<std::byte, 4096> buffer{};
  RealTimeSample sample;
  while (const auto message = other.receive(buffer)) {
    if (kind_of(*message) == TelemetryMessageKind::statistics)
      sample = content_of<StatisticsMessage>(*message)->sample;
  }
  return sample;
}

TEST(TelemetryTask, RejectedFramesAreCountedByCause) {
  SharedState shared{25'000, 1};
  ReceiveTask receive{shared};
  send_every_cause(receive);
  const RealTimeSample sample = statistics_of(shared);
  std::uint64_t frames = 3;
  std::uint64_t sum = 0;
  for (const CountedCause& counted : counted_causes) {
    SCOPED_TRACE(to_string(counted.cause));
    EXPECT_EQ(sample.*counted.count, frames);
    sum += frames++;
  }
  EXPECT_EQ(sample.rejected_not_valid_yet, 2U);
  EXPECT_EQ(sample.commands_rejected, sum + 2);
  EXPECT_EQ(sample.commands_received, receive.receiver().count(FrameVerdict::accepted));
}

TEST(TelemetryTask, TheWindingsTemperatureIsInKelvinAndZeroWhereNoneIsKnown) {
  for (const std::optional<double> celsius : {std::optional<double>{}, std::optional{81.5}}) {
    SharedState shared{25'000, 1};
    shared.telemetry.push({.winding_temperature = celsius});
    EXPECT_DOUBLE_EQ(statistics_of(shared).winding_temperature_k, celsius ? 354.65 : 0.0);
  }
}

TEST(TelemetryTask, StatisticsCountTheParametersThatTheDriveHasTaken) {
  SharedState shared{25'000, 1};
  shared.parameter_sets = 3;
  EXPECT_EQ(statistics_of(shared).parameter_sets, 3U);
}

// Once as a gap in the numbers of the samples, and once as a count that CAN and DDS bear.
TEST(TelemetryTask, ControlPeriodsThatThePublisherDoesNotReceiveAreDropped) {
  SharedState shared{25'000, 1};
  TelemetrySender sender;
  TelemetryTask task{{.periods_per_sample = 4}, sender, shared};
  for (int period = 0; period < 12; ++period) shared.telemetry.push({});
  task.poll(ms);
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  for (int period = 0; period < 4; ++period) shared.telemetry.push({});
  task.poll(2 * ms);
  EXPECT_EQ(shared.dropped_periods(), 12U);
  std::array<std::byte, 4096> buffer{};
  std::optional<IntervalMessage> interval;
  while (const auto message = other.receive(buffer)) {
    if (kind_of(*message) == TelemetryMessageKind::interval) interval = content_of<IntervalMessage>(*message);
  }
  ASSERT_TRUE(interval);
  EXPECT_EQ(interval->sequence, 3U);
  EXPECT_EQ(interval->dropped, 12U);
}

TEST(TelemetryTask, LogsOnceThatTheHousekeepingThreadHasStopped) {
  SharedState shared{25'000, 1};
  TelemetrySender sender;
  shared.housekeeping_polls.store(1);
  int logged = 0;
  TelemetryTask telemetry{{}, sender, shared, [&](const std::string&) { ++logged; }};
  telemetry.start(0, {});
  constexpr int timeout = ThreadWatch::timeout_ms / TelemetryTask::poll_every_ms;
  for (int poll = 0; poll < 3 * timeout; ++poll) telemetry.poll(0);
  EXPECT_EQ(logged, 1);
  shared.housekeeping_polls.store(2);
  for (int poll = 0; poll < timeout / 2; ++poll) telemetry.poll(0);
  EXPECT_EQ(logged, 2) << "it runs again";
}

TEST(TelemetryTask, ARampToZeroAndAFaultAreToldAndLoggedOnce) {
  SharedState shared{25'000, 1};
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  std::vector<std::string> logged;
  TelemetryTask task{{}, sender, shared, [&](const std::string& sentence) { logged.push_back(sentence); }};
  Telemetry<double> record;
  record.t_ns = 1'000 * ms;
  record.state = DriveState::torque;
  const auto told = [&](DeratingCause cause) {
    record.derating_cause = cause;
    for (int period = 0; period < 3; ++period) shared.telemetry.push(record);
    task.poll(record.t_ns);
    const auto newest = newest_state(other);
    return newest ? std::string{newest->sample().reason} : "";
  };
  EXPECT_EQ(told(DeratingCause::none), "torque reference as requested");
  EXPECT_EQ(told(DeratingCause::voltage_limit), "") << "no change of the state";
  const std::string late = "ramp to zero: no command within command.timeout_ms";
  EXPECT_EQ(told(DeratingCause::command_timeout), late);
  EXPECT_EQ(told(DeratingCause::none), "torque reference as requested");
  record.state = DriveState::fault;
  record.first_fault = Fault::over_current;
  record.latched.set(Fault::over_current);
  const std::string fault = told(DeratingCause::gates_are_off);
  EXPECT_EQ(logged, (std::vector<std::string>{"TORQUE: " + late, "FAULT: " + fault}));
}

TEST(TelemetryTask, ADeratedDriveTellsWhatTakesTheTorqueAway) {
  Telemetry<double> record;
  record.state = DriveState::derated;
  const auto told = [&](DeratingCause cause) {
    record.derating_cause = cause;
    return reason_for(record);
  };
  const std::string below = "torque below the request: ";
  EXPECT_EQ(told(DeratingCause::temperature), below + "the winding is hot");
  EXPECT_EQ(told(DeratingCause::dc_link_low), below + "the link voltage is low");
  EXPECT_EQ(told(DeratingCause::dc_link_high), below + "the link voltage is high");
  EXPECT_EQ(told(DeratingCause::current_limit), below + "less is available");
  EXPECT_TRUE(told(DeratingCause::shutdown).starts_with("ramp to zero"));
}

/// The waveforms that have arrived at the other end.
std::vector<WaveformMessage> waveforms(MessageSocket& socket) {
  std::vector<WaveformMessage> arrived;
  std::vector<std::byte> buffer(1 << 16);
  while (const auto message = socket.receive(buffer)) {
    if (kind_of(*message) != TelemetryMessageKind::waveform) continue;
    arrived.push_back(content_of<WaveformMessage>(*message).value());
  }
  return arrived;
}

/// The drive's records of control periods of 25 µs from t_ns on, which the task takes a hundred at a time.
void run_periods(SharedState& shared, TelemetryTask& task, std::int64_t& t_ns, int periods) {
  for (int k = 0; k < periods; ++k, t_ns += 25'000) {
    Telemetry<double> x;
    x.t_ns = t_ns;
    shared.telemetry.push(x);
    if (k % 100 == 99) task.poll(t_ns);
  }
}

TEST(TelemetryTask, WaveformsAreSentWhileTheyAreRead) {
  SharedState shared{25'000, 1};
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  TelemetryTask task{{}, sender, shared};
  std::int64_t t_ns = 0;
  const auto run = [&](int periods) { run_periods(shared, task, t_ns, periods); };
  run(1000);
  EXPECT_TRUE(waveforms(other).empty()) << "nobody reads";
  sender.set_waveform_is_read(true);
  run(1000);
  const auto arrived = waveforms(other);
  ASSERT_EQ(arrived.size(), 2U) << "the third is not complete";
  EXPECT_EQ(arrived[0].sequence, 0U);
  EXPECT_EQ(arrived[0].batch.t_ns, 25'000'000);
  EXPECT_EQ(arrived[1].sequence, 1U);
  EXPECT_EQ(arrived[1].batch.t_ns, 35'000'000);
  EXPECT_EQ(arrived[1].batch.offset_ns.size(), 400U);
  sender.set_waveform_is_read(false);
  run(1000);
  EXPECT_TRUE(waveforms(other).empty());
  sender.set_waveform_is_read(true);
  run(100);
  task.finish();
  const auto last = waveforms(other);
  ASSERT_EQ(last.size(), 1U) << "the end of the drive ends a batch";
  EXPECT_EQ(last[0].sequence, 2U);
  EXPECT_EQ(last[0].batch.t_ns, 75'000'000) << "nothing from before";
  EXPECT_EQ(last[0].batch.offset_ns.size(), 100U);
}

TEST(TelemetryTask, WaveformsWithoutAPublisherAreMissingInTheSequence) {
  SharedState shared{25'000, 1};
  TelemetrySender sender;
  auto [own, other] = MessageSocket::pair();
  sender.connect(std::move(own));
  sender.set_waveform_is_read(true);
  TelemetryTask task{{}, sender, shared};
  std::int64_t t_ns = 0;
  const auto run = [&](int periods) { run_periods(shared, task, t_ns, periods); };
  run(1200);
  ASSERT_EQ(waveforms(other).size(), 2U) << "the third is not complete";
  sender.disconnect();
  run(2000);
  auto [own_again, other_again] = MessageSocket::pair();
  sender.connect(std::move(own_again));
  run(1200);
  const auto after = waveforms(other_again);
  ASSERT_FALSE(after.empty());
  // Each batch that nobody took has its number.
  EXPECT_EQ(after[0].batch.t_ns, std::int64_t(after[0].sequence) * 10'000'000);
  EXPECT_GE(after[0].sequence, 7U);
}

TEST(ReasonFor, ADeratedDriveTellsLessTorqueFromATorqueThatTheVoltageHolds) {
  Telemetry<double> t{.torque_requested = -100,
                      .torque_reference = -60,
                      .torque_reached = -60,
                      .state = DriveState::derated,
                      .derating_cause = DeratingCause::voltage_limit};
  EXPECT_EQ(reason_for(t), "torque below the request: less is available");
  t.torque_reached = -90;
  EXPECT_EQ(reason_for(t), "the link voltage holds the torque off its reference");
  t.derating_cause = DeratingCause::command_timeout;
  EXPECT_EQ(reason_for(t), "ramp to zero: no command within command.timeout_ms");
}

}  // namespace
}  // namespace sextant::ecu
