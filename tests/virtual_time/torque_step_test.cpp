// Torque steps in all four quadrants over CAN, in virtual time: how soon the torque is there and how near.

#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "virtual_time/virtual_rig.hpp"

namespace sextant::test {
namespace {

constexpr std::int64_t reach_ns = 10 * ms;  // from the reception of the command
constexpr std::int64_t hold_ns = 500 * ms;
constexpr std::size_t periods_a_mean = 40;
constexpr double tolerance_nm = 1.5;  // of such a mean, with its ripple

/// What one step has shown.
struct Step {
  std::int64_t received_ns{never_ns};  ///< of the first command with the new torque [ns]
  std::int64_t there_ns{never_ns};     ///< end of the first millisecond whose mean is there [ns]
  double mean{};                       ///< over the half second after `reach_ns` [N·m]
  double worst_speed{};                ///< distance from the imposed speed [rad/s]
};

Step step(VirtualRig& rig, double torque, double omega_m) {
  Step found;
  std::vector<double> window;
  double sum = 0.0;
  int count = 0;
  rig.on_period = [&](const Telemetry<double>& t) {
    EXPECT_EQ(t.state, DriveState::torque);
    found.worst_speed = std::max(found.worst_speed, std::abs(t.omega_m - omega_m));
    // As CAN carries it.
    if (found.received_ns == never_ns && std::abs(t.torque_requested - torque) < 0.006) {
      found.received_ns = t.command_received_ns;
      window.clear();
    }
    if (found.received_ns == never_ns) return;
    window.push_back(t.torque);
    if (window.size() == periods_a_mean) {
      const double mean = std::accumulate(window.begin(), window.end(), 0.0) / double(periods_a_mean);
      if (found.there_ns == never_ns && std::abs(mean - torque) <= tolerance_nm) found.there_ns = t.t_ns;
      window.clear();
    }
    if (t.t_ns > found.received_ns + reach_ns && t.t_ns <= found.received_ns + reach_ns + hold_ns) {
      EXPECT_NEAR(t.torque_reference, torque, 0.006);
      sum += t.torque;
      ++count;
    }
  };
  rig.torque = torque;
  rig.run_for(hold_ns + 3 * reach_ns);
  rig.on_period = {};
  found.mean = sum / count;
  return found;
}

class TorqueStep : public testing::TestWithParam<double> {};

TEST_P(TorqueStep, IsThereWithin10MsOfItsCommandAndStays) {
  const double omega_m = GetParam();
  for (const int wake_every_periods : {1, 40}) {
    SCOPED_TRACE(wake_every_periods);
    VirtualRig rig{{.torque = 1.0, .omega_m = omega_m, .wake_every_periods = wake_every_periods}};
    ASSERT_TRUE(rig.start());
    for (const double torque : {15.0, 40.0, 15.0, -15.0, -40.0, -15.0, 15.0, 0.0}) {
      SCOPED_TRACE(torque);
      const Step found = step(rig, torque, omega_m);
      ASSERT_NE(found.received_ns, never_ns);
      EXPECT_LE(found.there_ns, found.received_ns + reach_ns);
      EXPECT_LT(found.worst_speed, 0.1);
      EXPECT_NEAR(found.mean, torque, 0.1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FourQuadrants, TorqueStep, testing::Values(0.0, 30.0, -30.0, 100.0, -100.0),
                         [](const auto& row) {
                           const double omega = row.param;
                           return (omega < 0 ? "Minus" : "Plus") + std::to_string(int(std::abs(omega)));
                         });

}  // namespace
}  // namespace sextant::test
