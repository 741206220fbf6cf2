// Drive and plant on one link in one process, period by period: what each sees of the other.
#include "sextant/hil/shared_memory_drive_io.hpp"

#include <optional>

#include <gtest/gtest.h>

#include "hil/test_link.hpp"
#include "sextant/hil/plant_server.hpp"
#include "sextant/hil/shared_memory_plant_end.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 100'000;
const GatePattern v1{switch_states[1], period_ns};
const GatePattern v2{switch_states[2], period_ns};
const GatePattern open{gates_off, period_ns};

/// A power stage that remembers what it was told; its speed counts its periods.
class Stage final : public DriveIo<double> {
 public:
  [[nodiscard]] Measurement<double> read(std::int64_t /*t_ns*/) noexcept override {
    Measurement<double> m{.u_dc = 530, .applied = any_ ? pattern : GatePattern{}};
    m.omega_m = ++periods_;
    any_ = true;
    return m;
  }
  void write(const GatePattern& p) noexcept override { pattern = p; }

  GatePattern pattern{};

 private:
  bool any_{false};
  double periods_{0};
};

struct PlantSide {
  explicit PlantSide(const HilParameters& p) : link{p, LinkRole::plant, period_ns} {}
  void step(std::int64_t t_ns) { server.step(t_ns); }

  SharedMemoryLink link;
  Stage stage{};
  SharedMemoryPlantEnd end{link};
  PlantServer<SharedMemoryPlantEnd> server{{period_ns, 1, 5'000'000}, stage, end};
};

struct DriveSide {
  explicit DriveSide(const HilParameters& p) : link{p, LinkRole::drive, period_ns} {}
  Measurement<double> cycle(std::int64_t t_ns, const GatePattern& pattern) {
    const Measurement<double> m = io.read(t_ns);
    io.write(pattern);
    return m;
  }

  SharedMemoryLink link;
  SharedMemoryDriveIo io{link, {.measurement_timeout_ns = 1'000'000}};
};

class SharedMemoryDriveIoTest : public testing::Test {
 protected:
  /// One period of both; returns what the drive measured.
  Measurement<double> period(const GatePattern& pattern) {
    t_ns += period_ns;
    plant->step(t_ns);
    return drive->cycle(t_ns, pattern);
  }
  /// One period in which the drive does nothing.
  void plant_alone() {
    t_ns += period_ns;
    plant->step(t_ns);
  }
  void plant_alone_for(std::int64_t ns) {
    for (const std::int64_t end = t_ns + ns; t_ns < end;) plant_alone();
  }
  /// One period of both, of a drive that makes torque until a measurement trips it. Returns whether it does.
  bool torque_period() {
    t_ns += period_ns;
    plant->step(t_ns);
    const bool plausible = drive->io.read(t_ns).plausible;
    tripped = tripped || !plausible;
    drive->io.write(tripped ? open : v1);
    return !tripped;
  }
  void bring_to_torque() {
    for (int n = 0; n < 5; ++n) (void)period(open);
    for (int n = 0; n < 20; ++n) ASSERT_TRUE(torque_period());
    ASSERT_EQ(plant->stage.pattern, v1);
  }
  /// Both sides are safe, and stay so: the drive tripped, the gates turn off.
  void expect_both_safe() {
    for (int n = 0; n < 20; ++n) {
      (void)torque_period();
      ASSERT_EQ(plant->stage.pattern, open);
    }
    EXPECT_TRUE(tripped);
  }

  test::TestLink link;
  std::optional<PlantSide> plant{std::in_place, link.parameters};
  std::optional<DriveSide> drive{std::in_place, link.parameters};
  std::int64_t t_ns{1'000'000'000};
  bool tripped{false};
};

TEST_F(SharedMemoryDriveIoTest, APatternActsOverTheNextPlantPeriodAndIsMeasured) {
  (void)period(open);
  (void)period(v1);
  const Measurement<double> before = period(v2);
  EXPECT_EQ(before.applied, open) << "v1 was written after this period had begun";
  EXPECT_EQ(period(v2).applied, v1);
  EXPECT_EQ(period(v2).applied, v2);
  EXPECT_TRUE(period(v2).plausible);
  EXPECT_EQ(drive->io.counts()->measurements.missing, 0U);
}

TEST_F(SharedMemoryDriveIoTest, ADriveThatMissesPeriodsReceivesAllAppliedPatterns) {
  (void)period(open);
  (void)period(v1);
  plant_alone();  // v1 begins
  plant_alone();  // v1 is not renewed: open
  plant_alone();
  const Measurement<double> m = period(v2);
  GatePattern expected = open;
  expected.append({switch_states[1], period_ns});
  expected.append({gates_off, 2 * period_ns});
  EXPECT_EQ(m.applied, expected);
  EXPECT_TRUE(m.plausible);
}

TEST_F(SharedMemoryDriveIoTest, ADriveThatTakesItsTimeToStartBeginsWithTheNewestMeasurement) {
  plant_alone_for(3 * std::int64_t{LinkMemory::ring_capacity} * period_ns);
  const Measurement<double> m = period(open);
  EXPECT_TRUE(m.plausible);
  EXPECT_EQ(m.applied, open);
  EXPECT_EQ(drive->io.counts()->measurements.records, 1U);
}

TEST_F(SharedMemoryDriveIoTest, ADriveWithoutAPlantIsNotPlausibleUntilOneComes) {
  plant.reset();
  for (int n = 0; n < 20; ++n) EXPECT_FALSE(drive->cycle(t_ns += period_ns, open).plausible);
  EXPECT_TRUE(drive->io.link_state()->timed_out());
  plant.emplace(link.parameters);
  EXPECT_TRUE(period(open).plausible);
  EXPECT_FALSE(drive->io.link_state()->timed_out());
}

TEST_F(SharedMemoryDriveIoTest, APlantThatDiesAndComesBackIsSeenBothTimes) {
  (void)period(open);
  plant.reset();
  bool fell_silent = false;
  for (int n = 0; n < 11; ++n) fell_silent = !drive->cycle(t_ns += period_ns, open).plausible;
  EXPECT_TRUE(fell_silent) << "1 ms is the limit";
  plant.emplace(link.parameters);
  EXPECT_FALSE(period(open).plausible) << "another plant than the one whose flux the drive knows";
  EXPECT_TRUE(period(open).plausible);
  EXPECT_EQ(drive->io.counts()->measurements.restarts, 1U);
}

TEST_F(SharedMemoryDriveIoTest, AHeartbeatThatStopsTurnsTheGatesOffWithinTheLimit) {
  (void)period(open);
  (void)period(v1);
  plant_alone();
  EXPECT_EQ(plant->stage.pattern, v1);
  const std::int64_t last_ns = t_ns;
  plant_alone_for(6'000'000);
  EXPECT_EQ(plant->stage.pattern, open);
  EXPECT_EQ(plant->server.guard().cause(), GateCause::timed_out);
  EXPECT_LE(plant->server.guard().off_since_ns() - last_ns, 10'000'000);
  GateEvent event;
  GateEvent newest;
  while (plant->server.events().pop(event)) newest = event;
  EXPECT_EQ(newest.cause, GateCause::timed_out);
  EXPECT_EQ(newest.last_pattern_ns, last_ns);
}

TEST_F(SharedMemoryDriveIoTest, TheWatchdogsLineTurnsTheGatesOffWhateverTheDriveWrites) {
  (void)period(open);
  (void)period(v1);
  (void)period(v1);
  EXPECT_EQ(plant->stage.pattern, v1);
  drive->io.inhibit_gates();
  for (int n = 0; n < 5; ++n) {
    (void)period(v1);
    EXPECT_EQ(plant->stage.pattern, open) << "a torque pattern does not close the line";
  }
  EXPECT_EQ(plant->server.guard().cause(), GateCause::disabled);
  (void)period(open);  // the drive has seen the watchdog's order
  (void)period(v1);
  (void)period(v1);
  EXPECT_EQ(plant->stage.pattern, v1);
}

TEST_F(SharedMemoryDriveIoTest, ANewDriveHasToShowGatesOffFirst) {
  (void)period(open);
  (void)period(v1);
  (void)period(v1);
  drive.reset();
  plant_alone();
  EXPECT_EQ(plant->stage.pattern, open);
  EXPECT_EQ(plant->server.guard().cause(), GateCause::absent);
  drive.emplace(link.parameters);
  plant_alone();
  EXPECT_EQ(plant->stage.pattern, open) << "what the dead drive has left is no command";
  (void)period(v1);
  (void)period(v1);
  EXPECT_EQ(plant->stage.pattern, open);
  (void)period(open);
  (void)period(v1);
  (void)period(v1);
  EXPECT_EQ(plant->stage.pattern, v1);
  EXPECT_EQ(plant->server.guard().counters().drives, 2U);
}

// A plant that is stopped in the middle of a copy tells by the number alone that it was another record.
TEST_F(SharedMemoryDriveIoTest, TheNumbersOfADriveThatWasStartedAnewGoOn) {
  for (int n = 0; n < 10; ++n) (void)period(open);
  DrivePatternRecord last;
  EXPECT_EQ(plant->link.memory().command.load(last), 10U);
  EXPECT_EQ(last.sequence, 10U);
  drive.reset();
  drive.emplace(link.parameters);
  (void)period(open);
  EXPECT_EQ(plant->link.memory().command.load(last), 11U);
  EXPECT_EQ(last.sequence, 11U);
  plant_alone();
  EXPECT_EQ(plant->server.guard().counters().missing, 0U);
  EXPECT_EQ(plant->server.guard().counters().drives, 2U);
}

TEST_F(SharedMemoryDriveIoTest, APlantThatComesAfterTheDriveDoesNotObeyWhatWasWrittenBefore) {
  plant.reset();
  (void)drive->cycle(t_ns, open);
  (void)drive->cycle(t_ns, v1);
  plant.emplace(link.parameters);
  plant_alone();
  EXPECT_EQ(plant->stage.pattern, open);
}

// Stopped between reading and writing: what it writes when it goes on is torque of before.
TEST_F(SharedMemoryDriveIoTest,
       ADriveThatWasStoppedInMidPeriodForLongerThanTheTimeoutTripsAndTheGatesStayOff) {
  for (const std::int64_t stopped_ns : {5'500'000, 50'000'000, 2'000'000'000}) {
    SCOPED_TRACE(stopped_ns);
    tripped = false;
    bring_to_torque();
    plant->step(t_ns += period_ns);
    (void)drive->io.read(t_ns);
    plant_alone_for(stopped_ns);
    EXPECT_EQ(plant->server.guard().cause(), GateCause::timed_out);
    drive->io.write(v1);
    int periods = 0;
    while (torque_period()) {
      ASSERT_EQ(plant->stage.pattern, open);
      ASSERT_LT(++periods, 5) << "the drive never found out";
    }
    expect_both_safe();
  }
}

TEST_F(SharedMemoryDriveIoTest, ADriveThatWasAwayForLessThanTheTimeoutGoesOn) {
  bring_to_torque();
  for (int round = 0; round < 10; ++round) {
    plant_alone_for(4'000'000);
    for (int n = 0; n < 3; ++n) EXPECT_TRUE(torque_period());
    EXPECT_EQ(plant->stage.pattern, v1);
  }
}

TEST_F(SharedMemoryDriveIoTest, ALineThatSomebodyElseTookAwayTripsTheDrive) {
  bring_to_torque();
  plant->link.memory().gate_enable.store(0);
  int periods = 0;
  while (torque_period()) ASSERT_LT(++periods, 5);
  expect_both_safe();
  EXPECT_GT(drive->io.link_state()->refusals(), 0U);
  EXPECT_FALSE(drive->io.link_state()->unacknowledged());
}

TEST_F(SharedMemoryDriveIoTest, APlantThatTakesNoPatternsAnyMoreTripsTheDrive) {
  bring_to_torque();
  plant_alone();  // takes the newest, follows it and lets it run out
  plant_alone();
  MeasurementRecord record = to_record(t_ns, Measurement<double>{.u_dc = 530, .applied = open});
  record.pattern_number = plant->server.guard().pattern_number();
  int periods = 0;
  for (; !tripped && periods < 1000; ++periods) {
    plant->end.publish(record);
    tripped = !drive->cycle(t_ns += period_ns, v1).plausible;
  }
  EXPECT_TRUE(drive->io.link_state()->unacknowledged());
  EXPECT_EQ(periods, 1 + MeasurementAssembler::Parameters{}.unacknowledged_periods)
      << "the first tells of the newest";
}

TEST_F(SharedMemoryDriveIoTest, ADriveThatSleptLongerThanTheRingLosesRecordsAndSaysSo) {
  (void)period(open);
  for (std::size_t n = 0; n < LinkMemory::ring_capacity + 100; ++n) plant_alone();
  EXPECT_FALSE(period(open).plausible);
  EXPECT_GT(drive->io.counts()->measurements.missing, 99U);
  EXPECT_TRUE(period(open).plausible);
}

}  // namespace
}  // namespace sextant
