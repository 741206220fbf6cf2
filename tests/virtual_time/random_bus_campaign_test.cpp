// A bus that misbehaves at random: what must hold whatever happens to the frames.

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "virtual_time/campaign.hpp"

namespace sextant::test {
namespace {

constexpr std::uint64_t seeds = 60;
constexpr std::int64_t storm_end_ns = 1000 * ms;

VirtualRigParameters stormy(const CampaignCase& c) {
  VirtualRigParameters p = c.rig;
  RandomBusEvents storm{.seed = c.seed, .begin_ns = 200 * ms, .end_ns = storm_end_ns};
  storm.kinds.insert(storm.kinds.end(),
                     {BusEventKind::bus_off, BusEventKind::interface_down, BusEventKind::refuse_transmit});
  if (c.seed % 2 == 0) storm.longest_ns = 150 * ms;
  p.bus = draw(storm);
  p.vehicle.clear_faults = true;
  return p;
}

TEST(RandomBusCampaign, NoTorqueWithoutAFreshCommandWhateverTheBusDoes) {
  std::uint64_t faults = 0;
  for_seeds(seeds, [&](CampaignCase& c) {
    VirtualRig rig{stormy(c)};
    ASSERT_TRUE(rig.start());
    rig.on_period = [&](const Telemetry<double>& t) {
      const std::int64_t age_ns = t.t_ns - t.command_received_ns;
      ASSERT_TRUE(std::isfinite(t.torque) && std::isfinite(t.torque_reference));
      // Only torque that the vehicle asked for, whatever the bytes looked like.
      const double share = t.torque_reference / c.rig.torque;
      ASSERT_TRUE(share >= 0.0 && share <= 1.0) << t.torque_reference;
      if (age_ns > 60 * ms) {
        ASSERT_EQ(t.torque_reference, 0.0);
      }
      if (age_ns > 200 * ms) {
        ASSERT_FALSE(gates_are_on(t.state));
      }
      if (t.latched.any()) {
        ASSERT_EQ(t.pattern.last_state(), gates_off);
      }
    };
    rig.run_until(storm_end_ns);
    EXPECT_GT(rig.bus.counts().lost + rig.bus.counts().corrupted + rig.bus.counts().delayed, 0U);
    // Once the bus is quiet again, and a second sender no longer assumed, the hand-shake brings the torque
    // back.
    rig.run_for(2000 * ms);
    EXPECT_EQ(rig.now().state, DriveState::torque);
    EXPECT_EQ(rig.now().torque_reference, c.rig.torque);
    faults += rig.now().fault_total;
  });
  EXPECT_GT(faults, seeds / 10) << "such a bus has to trip a drive now and then";
}

TEST(RandomBusCampaign, ASeedMakesOneRunAndAnotherSeedAnother) {
  std::vector<std::uint64_t> digests;
  for_seeds(8, [&](CampaignCase& c) {
    VirtualRig first{stormy(c)};
    VirtualRig second{stormy(c)};
    first.run_until(storm_end_ns);
    // In pieces, and between the steps of nobody: how it is run must not matter.
    for (std::int64_t t = 7'777'777; t < storm_end_ns; t += 7'777'777) second.run_until(t);
    second.run_until(storm_end_ns);
    EXPECT_EQ(first.recorder.digest(), second.recorder.digest());
    EXPECT_EQ(first.recorder.frames(), second.recorder.frames());
    digests.push_back(first.recorder.digest());
  });
  std::ranges::sort(digests);
  EXPECT_EQ(std::ranges::unique(digests).begin(), digests.end());
}

}  // namespace
}  // namespace sextant::test
