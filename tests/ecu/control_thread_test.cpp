#include "ecu/control_thread.hpp"

#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "ecu/can_receive_thread.hpp"
#include "ecu/can_transmit_thread.hpp"
#include "ecu/eventually.hpp"
#include "ecu/fake_can_bus.hpp"
#include "ecu/watchdog_thread.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr std::int64_t limit_ns = 300'000'000;

/// The simulated power stage, which can hold the control thread up.
class StallingIo final : public DriveIo<double> {
 public:
  explicit StallingIo(DriveIo<double>& io) : io_{io} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept override { return io_.read(t_ns); }
  void write(const GatePattern& pattern) noexcept override {
    io_.write(pattern);
    const std::int64_t stall_ns = stall_ns_.exchange(0);
    if (stall_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds{stall_ns});
  }

  /// At the next write.
  void stall(std::int64_t duration_ns) { stall_ns_.store(duration_ns); }
  [[nodiscard]] bool has_stalled() const { return stall_ns_.load() == 0; }

 private:
  DriveIo<double>& io_;
  std::atomic<std::int64_t> stall_ns_{0};
};

class ControlThreadTest : public testing::Test {
 protected:
  void TearDown() override { stop(); }

  void start() { (void)control.start(); }

  void stop() {
    crossings.shutdown.store(true);
    control.join();
  }

  Crossings crossings{period_ns, 40};
  SimulatedPowerStage stage{{.integrator = IntegratorKind::fixed}, {}};
  StallingIo io{stage.io()};
  DirectTorqueController<double> controller{{}};
  Drive<double> drive{{}, controller};
  RealtimeParameters realtime{.lock_memory = false, .watchdog_ns = limit_ns};
  ControlThread control{realtime, period_ns, io, drive, crossings};
};

// The process as a whole was held up, so that no watchdog thread could see it.
TEST_F(ControlThreadTest, AStallIsAWatchdogFaultWithoutAWatchdogToSeeIt) {
  start();
  ASSERT_TRUE(test::eventually([this] { return crossings.status.latest().t_ns != 0; }));
  io.stall(limit_ns + 50'000'000);
  EXPECT_TRUE(test::eventually([this] { return crossings.status.latest().latched.test(Fault::watchdog); }));
  EXPECT_EQ(crossings.status.value().state, DriveState::fault);
  EXPECT_EQ(crossings.status.value().fault_total, 1U) << "one stall is one fault";
}

TEST_F(ControlThreadTest, EveryThreadTogetherRunsStallsFaultsAndLeaves) {
  test::FakeCanBus bus;
  CanReceiveThread receive{bus, crossings};
  CanTransmitThread transmit{bus, crossings};
  WatchdogThread watchdog{limit_ns, crossings};
  start();
  receive.start();
  transmit.start();
  watchdog.start();
  Telemetry<double> telemetry;
  bool faulted = false;
  io.stall(limit_ns + 50'000'000);
  EXPECT_TRUE(test::eventually([&] {
    while (crossings.telemetry.pop(telemetry)) faulted |= telemetry.latched.test(Fault::watchdog);
    return faulted;
  }));
  stop();
  transmit.join();
  receive.join();
  watchdog.join();
  while (crossings.telemetry.pop(telemetry)) {
  }
  EXPECT_EQ(telemetry.state, DriveState::shutdown);
  EXPECT_TRUE(crossings.stopped.load());
}

}  // namespace
}  // namespace sextant::ecu
