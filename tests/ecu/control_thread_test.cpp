#include "ecu/threads/control_thread.hpp"

#include <atomic>
#include <bit>
#include <chrono>
#include <csignal>
#include <optional>
#include <thread>

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "ecu/eventually.hpp"
#include "ecu/fake_can_bus.hpp"
#include "ecu/polled_task.hpp"
#include "ecu/tasks/transmit_task.hpp"
#include "ecu/tasks/watchdog_task.hpp"
#include "ecu/threads/receive_thread.hpp"
#include "ecu/timing/timing_statistics.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int32_t period_ns = 25'000;
// Longer than a machine stands still.
constexpr std::int64_t limit_ns = 2'000'000'000;
constexpr std::int64_t stall_ns = limit_ns + 500'000'000;

/// The simulated power stage, which can hold the control thread up.
class StallingIo final : public DriveIo<double> {
 public:
  explicit StallingIo(DriveIo<double>& io) : io_{io} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept override { return io_.read(t_ns); }
  void write(const GatePattern& pattern) noexcept override {
    io_.write(pattern);
    for (const std::int64_t end_ns = now_ns() + work_ns_.load(); now_ns() < end_ns;) {
    }
    const std::int64_t asked_ns = stall_ns_.exchange(0);
    if (asked_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds{asked_ns});
  }

  /// At the next write.
  void stall(std::int64_t duration_ns) { stall_ns_.store(duration_ns); }
  /// At every write.
  void work(std::int64_t duration_ns) { work_ns_.store(duration_ns); }

 private:
  DriveIo<double>& io_;
  std::atomic<std::int64_t> stall_ns_{0};
  std::atomic<std::int64_t> work_ns_{0};
};

class ControlThreadTest : public testing::Test {
 protected:
  void TearDown() override { stop(); }

  void start() {
    (void)control.start();
    control.go();
  }

  void stop() {
    shared.shutdown.store(true);
    control.join();
  }

  SharedState shared{period_ns, 40, limit_ns};
  SimulatedPowerStage stage{{.integrator = IntegratorKind::fixed}, {}};
  StallingIo io{stage.io()};
  DirectTorqueController<double> controller{{}};
  Drive<double> drive{{}, controller};
  RealtimeParameters realtime{.lock_memory = false};
  ControlTask task{{.period_ns = period_ns, .wake_every_periods = 40}, drive, shared};
  ControlThread control{realtime, io, task, shared};
};

// The process as a whole was held up, so that no watchdog thread could see it.
TEST_F(ControlThreadTest, AStallIsAWatchdogFaultWithoutAWatchdogToSeeIt) {
  start();
  ASSERT_TRUE(test::eventually([this] { return shared.status.latest().t_ns != 0; }));
  io.stall(stall_ns);
  EXPECT_TRUE(test::eventually([this] { return shared.status.latest().latched.test(Fault::watchdog); }));
  EXPECT_EQ(shared.status.value().state, DriveState::fault);
  // The plant takes no gap of more than a second, so that the measurement after it is a fault as well.
  const Telemetry<double>& status = shared.status.value();
  EXPECT_EQ(int(status.fault_total), std::popcount(status.latched.bits()))
      << "one stall is one fault of each";
}

TEST_F(ControlThreadTest, EveryThreadTogetherRunsStallsFaultsAndLeaves) {
  test::FakeCanBus bus;
  ReceiveTask receive_task{shared};
  TransmitTask transmit_task{bus, shared};
  WatchdogTask watchdog_task{shared};
  ReceiveThread receive{bus, {&receive_task}, shared.stopped};
  test::PolledTask transmit{shared, [&] { (void)transmit_task.poll(now_ns()); }};
  test::PolledTask watchdog{shared, [&] { watchdog_task.poll(now_ns()); }};
  start();
  receive.start();
  transmit.start();
  watchdog.start();
  Telemetry<double> telemetry;
  bool faulted = false;
  io.stall(stall_ns);
  EXPECT_TRUE(test::eventually([&] {
    while (shared.telemetry.pop(telemetry)) faulted |= telemetry.latched.test(Fault::watchdog);
    return faulted;
  }));
  stop();
  transmit.stop();
  receive.join();
  watchdog.stop();
  while (shared.telemetry.pop(telemetry)) {
  }
  EXPECT_EQ(telemetry.state, DriveState::shutdown);
  EXPECT_TRUE(shared.stopped.load());
}

/// One control period a wake-up, spinning.
class HardControlThreadTest : public testing::Test {
 protected:
  void TearDown() override {
    shared.shutdown.store(true);
    control.join();
  }

  /// The first miss whose gap is at least so long [ns].
  [[nodiscard]] std::optional<WakeRecord> miss_with_gap(std::int64_t gap_ns) {
    std::optional<WakeRecord> found;
    WakeRecord wake;
    const bool seen = test::eventually([&] {
      while (!found && shared.wakes.pop(wake)) {
        if (wake.overrun && wake.gap.longest_ns >= gap_ns) found = wake;
      }
      return found.has_value();
    });
    EXPECT_EQ(seen, found.has_value());
    return found;
  }

  SharedState shared{250'000, 1};
  SimulatedPowerStage stage{{.io = {.period_ns = 250'000}, .integrator = IntegratorKind::fixed}, {}};
  StallingIo io{stage.io()};
  DirectTorqueController<double> controller{{{.period_ns = 250'000}}};
  Drive<double> drive{{.period_ns = 250'000}, controller};
  RealtimeParameters realtime{
      .wake_every_periods = 1, .wait = {.mode = WaitMode::spin}, .lock_memory = false};
  ControlTask task{{.period_ns = 250'000, .wake_every_periods = 1}, drive, shared};
  ControlThread control{realtime, io, task, shared};
};

TEST_F(HardControlThreadTest, EveryPeriodIsTimedByStage) {
  (void)control.start();
  control.go();
  StageRecord stages{};
  WakeRecord wake;
  std::uint64_t periods = 0;
  std::uint64_t records = 0;
  EXPECT_TRUE(test::eventually([&] {
    while (shared.wakes.pop(wake)) periods = wake.periods;
    return periods > 100;
  }));
  shared.shutdown.store(true);
  control.join();
  while (shared.wakes.pop(wake)) periods = wake.periods;
  for (; shared.stages.pop(stages); ++records) {
    EXPECT_GT(stages[static_cast<std::size_t>(Stage::read)], 0U);
    EXPECT_GT(stages[static_cast<std::size_t>(Stage::drive)], 0U);
  }
  EXPECT_EQ(records, periods);
}

TEST_F(HardControlThreadTest, AStallInAStageIsAnOverrunWithItsGapThere) {
  (void)control.start();
  control.go();
  ASSERT_TRUE(test::eventually([this] { return shared.status.latest().t_ns != 0; }));
  io.stall(stall_ns);
  const std::optional<WakeRecord> miss = miss_with_gap(stall_ns);
  ASSERT_TRUE(miss.has_value());
  EXPECT_EQ(miss->gap.place, GapPlace::write);
  EXPECT_TRUE(miss->execution_overran);
  EXPECT_GE(miss->latency_ns, stall_ns - 1'000'000);
}

TEST_F(HardControlThreadTest, AStopWhileItWaitsIsAnOverrunWithItsGapThere) {
  struct sigaction action{};
  action.sa_handler = [](int) { std::this_thread::sleep_for(std::chrono::nanoseconds{stall_ns}); };
  ASSERT_EQ(sigaction(SIGUSR1, &action, nullptr), 0);
  (void)control.start();
  control.go();
  ASSERT_TRUE(test::eventually([this] { return shared.status.latest().t_ns != 0; }));
  // Most of a period is waiting, so that one of a few stops meets it.
  bool while_waiting = false;
  for (int i = 0; i < 20 && !while_waiting; ++i) {
    syscall(SYS_tgkill, getpid(), shared.control_thread_id.load(), SIGUSR1);
    const std::optional<WakeRecord> miss = miss_with_gap(stall_ns);
    ASSERT_TRUE(miss.has_value());
    while_waiting = miss->gap.place == GapPlace::waiting && !miss->execution_overran;
  }
  EXPECT_TRUE(while_waiting);
}

TEST_F(HardControlThreadTest, AStallIsTheLongestGapOfOneWakeUpAndOfNoOther) {
  (void)control.start();
  control.go();
  ASSERT_TRUE(test::eventually([this] { return shared.status.latest().t_ns != 0; }));
  io.stall(stall_ns);
  WakeRecord wake;
  int stalled = 0;
  int after = 0;
  EXPECT_TRUE(test::eventually([&] {
    while (shared.wakes.pop(wake)) {
      if (wake.longest_gap_ns >= stall_ns) ++stalled;
      if (stalled > 0) ++after;
    }
    return after > 100;
  }));
  EXPECT_EQ(stalled, 1);
}

TEST_F(HardControlThreadTest, NoPeriodRunsBeforeItIsTold) {
  (void)control.start();
  std::this_thread::sleep_for(std::chrono::milliseconds{20});
  EXPECT_EQ(shared.heartbeat_ns.load(), 0);
  control.go();
  EXPECT_TRUE(test::eventually([this] { return shared.heartbeat_ns.load() != 0; }));
}

TEST_F(HardControlThreadTest, AThreadThatIsNeverToldLeavesWithoutAPeriod) {
  (void)control.start();
  control.join();
  EXPECT_EQ(shared.heartbeat_ns.load(), 0);
  EXPECT_TRUE(shared.stopped.load());
}

TEST_F(HardControlThreadTest, AGapThatWasMadeUpForIsNotBlamedLater) {
  (void)control.start();
  control.go();
  ASSERT_TRUE(test::eventually([this] { return shared.status.latest().t_ns != 0; }));
  io.stall(stall_ns);
  ASSERT_TRUE(miss_with_gap(stall_ns).has_value());
  WakeRecord wake;
  EXPECT_TRUE(test::eventually([&] {
    while (shared.wakes.pop(wake)) {
      if (!wake.execution_overran && wake.latency_ns == 0) return true;
    }
    return false;
  })) << "it never came back into time";
  const auto is_clean = [&] {
    while (shared.wakes.pop(wake)) {
      if (wake.execution_overran) continue;
      return wake.gap.longest_ns == 0 ||
             (wake.gap.place == GapPlace::waiting && wake.gap.longest_ns < stall_ns);
    }
    return false;
  };
  EXPECT_TRUE(test::eventually(is_clean));
}

/// More work than a period has time for, in stages that are no gap.
class OverloadedControlThreadTest : public HardControlThreadTest {
 protected:
  static constexpr std::int64_t work_ns = 300'000;
  static constexpr std::int64_t gap_limit_ns = 1'000'000;

  RealtimeParameters overloaded{.wake_every_periods = 1,
                                .wait = {.mode = WaitMode::spin},
                                .lock_memory = false,
                                .gap_limit_ns = gap_limit_ns};
  ControlThread thread{overloaded, io, task, shared};
};

// Whatever the machine does to this test: a miss is a gap's only where a gap was seen since the miss before.
TEST_F(OverloadedControlThreadTest, AnOldGapDoesNotExcuseTheWorkThatFollows) {
  io.work(work_ns);
  (void)thread.start();
  thread.go();
  io.stall(stall_ns);
  WakeRecord wake;
  bool gap_since_miss = false;
  int old_gaps = 0;
  int own = 0;
  int seen_gaps = 0;
  const bool enough = test::eventually([&] {
    while (shared.wakes.pop(wake)) {
      gap_since_miss |= wake.longest_gap_ns > gap_limit_ns;
      if (!wake.overrun) continue;
      seen_gaps += gap_since_miss ? 1 : 0;
      if (!gap_since_miss && seen_gaps > 0) {
        old_gaps += wake.gap.longest_ns > 0 ? 1 : 0;
        own += wake.gap.longest_ns == 0 && wake.execution_overran ? 1 : 0;
      }
      gap_since_miss = false;
    }
    return own + old_gaps > 20;
  });
  shared.shutdown.store(true);
  thread.join();
  EXPECT_TRUE(enough);
  EXPECT_GT(own, 0);
  EXPECT_EQ(old_gaps, 0);
}

}  // namespace
}  // namespace sextant::ecu
