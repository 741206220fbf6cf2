// A drive on a weak DC link, with and without bands of the link voltage. Where the band holds it, voltage and
// torque are the point at which the source's characteristic meets the line of the band:
//   u (E − u)/R = P,   T = T_max (u − u_zero)/(u_full − u_zero)
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {
namespace {

using Stage = LinkedMeteredPowerStage;
using Link = DcLink<>;
using Settings = std::vector<std::string>;

constexpr int paper = 1;
constexpr double omega_m = 100;

ScenarioConfig config_with(const DcLinkParameters<>& link, const std::string& torque, const Settings& set) {
  ScenarioConfig config =
      machine_config(test_machines[paper], {.omega_m = omega_m, .end_s = 1.5, .torque = torque, .set = set});
  config.drive.plant.link = link;
  config.drive.plant.integrator = IntegratorKind::fixed;
  return config;
}

/// What a run shows over its last 0.3 s.
struct Seen {
  Telemetry<double> last{};
  double u_mean{};     ///< [V]
  double u_swing{};    ///< peak to peak [V]
  double torque{};     ///< mean of the machine's [N·m]
  double power{};      ///< mean that the inverter draws [W]
  double available{};  ///< mean of the side of the command [N·m]
};

Seen run_on(const ScenarioConfig& config) {
  struct Records {
    void push(const Telemetry<double>& t) noexcept SEXTANT_NONBLOCKING { last = t; }
    Telemetry<double> last{};
  };
  Stage stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  ScenarioCommands commands{config.scenario};
  Records records;
  const std::int64_t period_ns = config.drive.drive.period_ns;
  const auto drawn = [&] {
    return stage.io().plant().state()[Stage::Plant::appended + Link::size + int(EnergyMeter<>::dc_link)];
  };
  Seen seen;
  double lowest = 1e9, highest = 0, before = 0;
  int count = 0;
  std::int64_t t_ns = -std::int64_t{ScenarioCommands::hand_shake_periods} * period_ns;
  for (; t_ns <= config.scenario.duration_ns; t_ns += period_ns) {
    run_cycle(t_ns, stage.io(), commands, drive, records);
    if (t_ns < config.scenario.duration_ns - 300'000'000) continue;
    if (count++ == 0) before = drawn();
    const double u = stage.io().plant().u_dc();
    seen.u_mean += u;
    seen.torque += stage.io().plant().tau_e();
    seen.available +=
        records.last.torque_requested < 0 ? records.last.torque_regenerating : records.last.torque_motoring;
    lowest = std::min(lowest, u);
    highest = std::max(highest, u);
  }
  seen.power = (drawn() - before) / (double(count - 1) * double(period_ns) * 1e-9);
  seen.u_mean /= count;
  seen.torque /= count;
  seen.available /= count;
  seen.u_swing = highest - lowest;
  seen.last = records.last;
  return seen;
}

// 530 V behind 10 Ω deliver 7.0 kW at most; 90 N·m at 100 rad/s ask for more than 9 kW.
TEST(LinkDeratingRun, ALoadThatSagsTheLinkHoldsAPowerInsteadOfTripping) {
  constexpr double e = 530, r = 10, full = 480, zero = 400;
  for (const double inductance : {0.0, 5e-3}) {
    SCOPED_TRACE(inductance);
    const DcLinkParameters<> weak{2e-3, r, inductance};
    const std::string torque = "[[0, 0], [0.4, 90]]";
    const Seen without = run_on(config_with(weak, torque, {"capability.torque_nm=100"}));
    EXPECT_EQ(without.last.state, DriveState::fault);
    EXPECT_EQ(without.last.first_fault, Fault::dc_under_voltage);

    const Seen with = run_on(config_with(
        weak, torque,
        {"capability.torque_nm=100", "capability.low_voltage_v=480", "capability.low_voltage_zero_v=400"}));
    EXPECT_EQ(with.last.state, DriveState::derated);
    EXPECT_EQ(with.last.derating_cause, DeratingCause::dc_link_low);
    EXPECT_GT(with.torque, 20);
    EXPECT_LT(with.torque, 60);
    EXPECT_NEAR(with.torque, with.available, 1);
    EXPECT_NEAR(with.torque, 100 * (with.u_mean - zero) / (full - zero), 1.5) << "line of the band";
    EXPECT_NEAR(with.power, with.u_mean * (e - with.u_mean) / r, 0.01 * with.power) << "source";
    EXPECT_LT(with.u_swing, 3);
  }
}

// A source that takes nothing back, and no chopper: what the machine returns is what it loses itself.
TEST(LinkDeratingRun, BrakingIntoALinkThatTakesNothingHoldsTheVoltageInTheBand) {
  constexpr double full = 560, zero = 640;
  const DcLinkParameters<> rectifier{2e-3, 0.5, 0, true};
  const std::string torque = "[[0, 0], [0.4, -60]]";
  const Seen without = run_on(config_with(rectifier, torque, {"capability.torque_nm=150"}));
  EXPECT_EQ(without.last.first_fault, Fault::dc_over_voltage);

  const Seen with = run_on(config_with(
      rectifier, torque,
      {"capability.torque_nm=150", "capability.high_voltage_v=560", "capability.high_voltage_zero_v=640"}));
  EXPECT_EQ(with.last.state, DriveState::derated);
  EXPECT_EQ(with.last.derating_cause, DeratingCause::dc_link_high);
  EXPECT_GT(with.u_mean, full);
  EXPECT_LT(with.u_mean, zero);
  EXPECT_NEAR(with.torque, -150 * (zero - with.u_mean) / (zero - full), 1);
  EXPECT_NEAR(with.power, 0, 20) << "W, of the 6 kW that are asked for";
  EXPECT_LT(with.torque, -0.5);
}

// A link that stays outside of the bands: the same run to the last bit.
TEST(LinkDeratingRun, BandsThatAreNotReachedChangeNothing) {
  const DcLinkParameters<> link{2e-3, 0.5};
  const std::string torque = "[[0, 0], [0.4, 60], [0.9, -60]]";
  const Seen plain = run_on(config_with(link, torque, {}));
  const Seen with =
      run_on(config_with(link, torque, {"capability.low_voltage_v=450", "capability.high_voltage_v=590"}));
  EXPECT_EQ(plain.u_mean, with.u_mean);
  EXPECT_EQ(plain.torque, with.torque);
  EXPECT_EQ(plain.power, with.power);
}

}  // namespace
}  // namespace sextant
