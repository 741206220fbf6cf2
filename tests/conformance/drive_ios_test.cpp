// The power stages of Sextant conform: simulated, and over each link.
#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hil/test_link.hpp"
#include "sextant/conformance/check_drive_io.hpp"
#include "sextant/hil/lockstep_drive_io.hpp"
#include "sextant/hil/lockstep_plant.hpp"
#include "sextant/hil/plant_server.hpp"
#include "sextant/hil/shared_memory_drive_io.hpp"
#include "sextant/hil/shared_memory_plant_end.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

using testing::IsEmpty;

constexpr std::int32_t period_ns = 100'000;

SimulatedPowerStage::Parameters stage_parameters(int delay = 0) {
  SimulatedPowerStage::Parameters p{.integrator = IntegratorKind::fixed};
  p.io.period_ns = period_ns;
  p.io.actuation_delay_periods = delay;
  return p;
}

std::vector<std::string> violations(const SimulatedPowerStage::Parameters& p) {
  SimulatedPowerStage stage{p, {}};
  return check_drive_io(stage.io(),
                        {.period_ns = period_ns, .actuation_delay_periods = p.io.actuation_delay_periods})
      .violations;
}

TEST(DriveIos, TheSimulatedOneConforms) {
  for (const int delay : {0, 1}) {
    auto p = stage_parameters(delay);
    EXPECT_THAT(violations(p), IsEmpty()) << delay;
    p.io.law = InverterLaw::averaged;
    EXPECT_THAT(violations(p), IsEmpty()) << delay << ", averaged";
  }
  auto p = stage_parameters();
  p.integrator = IntegratorKind::cvode;
  p.io.measures_angle = true;
  p.io.hold_periods = 3;
  p.io.dead_time_ns = 2'000;
  EXPECT_THAT(violations(p), IsEmpty());
}

TEST(DriveIos, ThatOfSharedMemoryConforms) {
  const test::TestLink link;
  SimulatedPowerStage stage{stage_parameters(), {}};
  SharedMemoryLink plant_link{link.parameters, LinkRole::plant, period_ns};
  SharedMemoryPlantEnd end{plant_link};
  PlantServer<SharedMemoryPlantEnd> server{{period_ns, 1, 5'000'000}, stage.io(), end};
  SharedMemoryLink drive_link{link.parameters, LinkRole::drive, period_ns};
  SharedMemoryDriveIo io{drive_link, {.measurement_timeout_ns = 1'000'000}};
  std::int64_t plant_ns = 0;
  const auto wait = [&](std::int64_t t_ns) {
    while (plant_ns < t_ns) server.step(plant_ns += period_ns);
  };
  const DriveIoConformanceParameters p{
      .period_ns = period_ns, .actuation_delay_periods = 1, .silent_periods = 100, .wait = wait};
  EXPECT_THAT(check_drive_io<double>(io, p).violations, IsEmpty());
  EXPECT_GT(server.guard().counters().drives, 0U);
}

TEST(DriveIos, ThatOfLockstepConforms) {
  test::TestLink link;
  link.parameters.pacing = Pacing::lockstep;
  std::jthread plant{[&link](const std::stop_token& stop) {
    SharedMemoryLink plant_link{link.parameters, LinkRole::plant, period_ns};
    SimulatedPowerStage stage{stage_parameters(), {}};
    LockstepPlant server{plant_link, stage.io(), link.parameters.lockstep_timeout_ns};
    using Outcome = LockstepPlant::Outcome;
    for (Outcome o = Outcome::waiting; !stop.stop_requested() && o <= Outcome::waiting;) o = server.step();
  }};
  SharedMemoryLink drive_link{link.parameters, LinkRole::drive, period_ns};
  LockstepDriveIo io{drive_link, link.parameters.lockstep_timeout_ns};
  EXPECT_THAT(check_drive_io<double>(io, {.period_ns = period_ns}).violations, IsEmpty());
}

}  // namespace
}  // namespace sextant
