// Drive and plant in lockstep, as two threads with a link between them.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "hil/test_link.hpp"
#include "sextant/hil/lockstep_drive_io.hpp"
#include "sextant/hil/lockstep_plant.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;

/// A first-order plant whose result depends on every pattern and on their order.
class Stage final : public DriveIo<double> {
 public:
  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept override {
    x_ += (double(pattern_.last_state().upper_switches()) - 0.3 * x_) * double(t_ns - t_ns_) * 1e-5;
    t_ns_ = t_ns;
    return {.i_abc = {x_, -x_, 0}, .u_dc = 530, .omega_m = 2 * x_, .applied = pattern_};
  }
  void write(const GatePattern& pattern) noexcept override { pattern_ = pattern; }

 private:
  GatePattern pattern_{};
  double x_{1};
  std::int64_t t_ns_{0};
};

class PlantThread {
 public:
  explicit PlantThread(const HilParameters& p, LockstepPlant::Observer observer = {})
      : thread_{[this, p, observer] { run(p, observer); }} {}
  ~PlantThread() { join(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }
  void stop() { stop_ = true; }
  [[nodiscard]] LockstepPlant::Outcome outcome() const { return outcome_; }

 private:
  void run(const HilParameters& p, const LockstepPlant::Observer& observer) {
    SharedMemoryLink link{p, LinkRole::plant, period_ns};
    Stage stage;
    LockstepPlant plant{link, stage, p.lockstep_timeout_ns};
    if (observer) plant.observe(observer);
    using Outcome = LockstepPlant::Outcome;
    do outcome_ = plant.step();
    while (!stop_ && (outcome_ == Outcome::stepped || outcome_ == Outcome::waiting));
  }

  std::atomic<bool> stop_{false};
  std::atomic<LockstepPlant::Outcome> outcome_{LockstepPlant::Outcome::waiting};
  std::thread thread_;
};

std::vector<double> run(const HilParameters& parameters, int periods) {
  SharedMemoryLink link{parameters, LinkRole::drive, period_ns};
  LockstepDriveIo io{link, parameters.lockstep_timeout_ns};
  std::vector<double> trace;
  for (int k = 0; k < periods; ++k) {
    const Measurement<double> m = io.read(std::int64_t{k} * period_ns);
    EXPECT_TRUE(m.plausible) << "period " << k;
    trace.push_back(m.i_abc.a);
    io.write({switch_states[m.i_abc.a > 3.0 ? 0 : std::size_t(k % 7 + 1)], period_ns});
  }
  return trace;
}

class LockstepTest : public testing::Test {
 protected:
  LockstepTest() { link.parameters.pacing = Pacing::lockstep; }
  test::TestLink link;
};

TEST_F(LockstepTest, TwoRunsAreEqualBitByBitAndEqualOneInTheSameProcess) {
  std::vector<std::vector<double>> traces;
  for (int n = 0; n < 2; ++n) {
    PlantThread plant{link.parameters};
    traces.push_back(run(link.parameters, 5000));
    plant.join();
    EXPECT_EQ(plant.outcome(), LockstepPlant::Outcome::left);
  }
  Stage stage;
  std::vector<double> direct;
  for (int k = 0; k < 5000; ++k) {
    const Measurement<double> m = stage.read(std::int64_t{k} * period_ns);
    direct.push_back(m.i_abc.a);
    stage.write({switch_states[m.i_abc.a > 3.0 ? 0 : std::size_t(k % 7 + 1)], period_ns});
  }
  EXPECT_EQ(traces[0], traces[1]);
  EXPECT_EQ(traces[0], direct);
  EXPECT_NE(traces[0].front(), traces[0].back());
}

TEST_F(LockstepTest, AnObserverGetsEachControlPeriodWithItsTimeAndSpeed) {
  struct Seen {
    DriveReport report;
    std::int64_t t_ns;
    double omega_m;
  };
  std::vector<Seen> seen;
  std::vector<double> speeds;
  PlantThread plant{link.parameters, [&](const DriveReport& report, std::int64_t t_ns, double omega_m) {
                      seen.push_back({report, t_ns, omega_m});
                    }};
  {
    SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
    LockstepDriveIo io{drive, link.parameters.lockstep_timeout_ns};
    for (int k = 0; k < 5; ++k) {
      speeds.push_back(io.read(std::int64_t{k} * period_ns).omega_m);
      io.write({switch_states[1], period_ns});
      Telemetry<double> telemetry{.torque_motoring = 10.0 + k, .state = DriveState::torque};
      if (k == 3) telemetry.latched.set(Fault::open_phase);
      telemetry.first_fault = Fault::open_phase;
      if (k != 1) io.report(to_report(telemetry, 7 * period_ns, 9));  // a period without a report is left out
    }
  }
  plant.join();
  ASSERT_EQ(seen.size(), 3U);  // the last period is followed by no request
  const std::int64_t periods[]{0, 2, 3};
  for (std::size_t n = 0; n < 3; ++n) {
    SCOPED_TRACE(n);
    const auto k = periods[n];
    EXPECT_EQ(seen[n].t_ns, k * period_ns);
    EXPECT_EQ(seen[n].omega_m, speeds[std::size_t(k)]);
    EXPECT_EQ(seen[n].report.begin_ns, 7 * period_ns);
    const Telemetry<double> told = to_telemetry(seen[n].report, seen[n].t_ns, seen[n].omega_m);
    EXPECT_EQ(told.t_ns, k * period_ns);
    EXPECT_EQ(told.torque_motoring, 10.0 + double(k));
    EXPECT_EQ(told.state, DriveState::torque);
    EXPECT_EQ(told.latched.any(), k == 3);
    EXPECT_EQ(told.latched.test(Fault::open_phase), k == 3);
    EXPECT_EQ(told.first_fault, Fault::open_phase);
  }
}

TEST_F(LockstepTest, TheRequestsOfADriveThatWasStartedAnewGoOn) {
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  for (const std::uint64_t expected : {1U, 2U}) {
    SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
    LockstepDriveIo io{drive, 1};
    (void)io.read(0);  // asks, and finds nobody who answers
    DrivePatternRecord request;
    EXPECT_EQ(plant.memory().command.load(request), expected);
    EXPECT_EQ(request.sequence, expected);
  }
}

TEST_F(LockstepTest, TheDriveMayComeFirst) {
  std::optional<PlantThread> plant;
  std::thread later{[&] {
    std::this_thread::sleep_for(std::chrono::milliseconds{150});
    plant.emplace(link.parameters);
  }};
  EXPECT_EQ(run(link.parameters, 10).size(), 10U);
  later.join();
}

TEST_F(LockstepTest, ADriveWithoutAPlantGivesUpAfterItsTimeAndStaysSo) {
  link.parameters.lockstep_timeout_ns = 60'000'000;
  SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
  LockstepDriveIo io{drive, link.parameters.lockstep_timeout_ns};
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(io.read(0).plausible);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds{60});
  EXPECT_TRUE(io.lost());
  EXPECT_FALSE(io.joined());
  EXPECT_FALSE(io.was_there());
  EXPECT_FALSE(io.read(period_ns).plausible);
}

TEST_F(LockstepTest, APlantThatCameAndDiedBeforeItAnsweredIsToldFromNone) {
  SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
  LockstepDriveIo io{drive, 600'000'000'000};
  std::thread shortly{[&] {
    const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
    while (!io.was_there()) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }};
  EXPECT_FALSE(io.read(0).plausible);
  shortly.join();
  EXPECT_TRUE(io.lost());
  EXPECT_FALSE(io.joined());
  EXPECT_TRUE(io.was_there());
}

TEST_F(LockstepTest, APlantThatGoesIsNoticedLongBeforeTheTimeout) {
  std::optional<PlantThread> plant{std::in_place, link.parameters};
  SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
  LockstepDriveIo io{drive, 600'000'000'000};
  ASSERT_TRUE(io.read(0).plausible);
  plant->stop();
  plant->join();
  EXPECT_FALSE(io.read(period_ns).plausible);
  EXPECT_TRUE(io.lost());
  EXPECT_TRUE(io.joined());
}

TEST_F(LockstepTest, ADriveWithoutRequestsIsLostAfterTheTimeout) {
  link.parameters.lockstep_timeout_ns = 2'000'000'000;  // longer than a machine stands still
  PlantThread plant{link.parameters};
  SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
  LockstepDriveIo io{drive, 60'000'000'000};
  ASSERT_TRUE(io.read(0).plausible);
  plant.join();
  EXPECT_EQ(plant.outcome(), LockstepPlant::Outcome::lost);
}

}  // namespace
}  // namespace sextant
