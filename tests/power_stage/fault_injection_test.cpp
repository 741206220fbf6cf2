// Faults that a simulated power stage is given while it runs.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 100'000;
constexpr std::size_t begin = 50;  // period in which the fault begins
constexpr std::size_t periods = 200;

SimulatedPowerStageParameters parameters(bool takes_faults, const PlantFaultParameters& fault = {}) {
  SimulatedPowerStageParameters p;
  p.plant.machine = {.r_s = 0.435, .r_r = 0.816, .l_ls = 2.4e-3, .l_lr = 2.4e-3, .l_m = 83e-3};
  p.plant.machine.inertia = 0.089;
  p.plant.machine.pole_pairs = 2;
  p.integrator = IntegratorKind::fixed;
  p.io.period_ns = std::int32_t(period_ns);
  p.io.takes_faults = takes_faults;
  p.io.fault = fault;
  return p;
}

/// A voltage along phase a for a third of each period, then one against it for two thirds, by turns of 20
/// periods.
GatePattern pattern_of(std::size_t k) {
  const bool along = k % 40 < 20;
  const SwitchState vector = along ? SwitchState{LegState::high, LegState::low, LegState::low}
                                   : SwitchState{LegState::low, LegState::high, LegState::high};
  const auto duration_ns = std::int32_t(along ? period_ns / 3 : 2 * period_ns / 3);
  GatePattern pattern;
  (void)pattern.append({vector, duration_ns});
  (void)pattern.append(
      {SwitchState{LegState::low, LegState::low, LegState::low}, std::int32_t(period_ns) - duration_ns});
  return pattern;
}

/// What it measures; the fault is given before the read of the period `begin`, and ended after 100 more.
std::vector<Measurement<double>> run(const SimulatedPowerStageParameters& p,
                                     const PlantFaultParameters& injected = {}) {
  SimulatedPowerStage stage{p, {}};
  std::vector<Measurement<double>> measured;
  for (std::size_t k = 0; k < periods; ++k) {
    if (k == begin && injected.kind != PlantFaultKind::none) stage.io().inject(injected);
    if (k == begin + 100 && injected.kind != PlantFaultKind::none) stage.io().inject({});
    measured.push_back(stage.io().read(std::int64_t(k) * period_ns));
    stage.io().write(pattern_of(k));
  }
  return measured;
}

void expect_same(const std::vector<Measurement<double>>& a, const std::vector<Measurement<double>>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].i_abc.a, b[k].i_abc.a) << k;
    ASSERT_EQ(a[k].i_abc.b, b[k].i_abc.b) << k;
    ASSERT_EQ(a[k].u_dc, b[k].u_dc) << k;
    ASSERT_EQ(a[k].omega_m, b[k].omega_m) << k;
  }
}

TEST(FaultInjection, APowerStageThatMayTakeFaultsIsBitByBitTheOtherOneUntilThen) {
  expect_same(run(parameters(true)), run(parameters(false)));
}

TEST(FaultInjection, WithoutTakesFaultsNothingChanges) {
  expect_same(run(parameters(false), {.kind = PlantFaultKind::current_zero}), run(parameters(false)));
}

TEST(FaultInjection, AReadingIsReplacedFromTheNextReadOnAndComesBack) {
  const auto right = run(parameters(false));
  const auto zero = run(parameters(true), {.kind = PlantFaultKind::current_zero, .phase = 1});
  const auto stuck = run(parameters(true), {.kind = PlantFaultKind::current_stuck, .phase = 0});
  for (std::size_t k = 0; k < periods; ++k) {
    const bool there = k >= begin && k < begin + 100;
    EXPECT_EQ(zero[k].i_abc.b, there ? 0.0 : right[k].i_abc.b) << k;
    EXPECT_EQ(zero[k].i_abc.a, right[k].i_abc.a) << k;
    EXPECT_EQ(stuck[k].i_abc.a, right[there ? begin - 1 : k].i_abc.a) << k;
  }
  EXPECT_GT(std::abs(right[begin - 1].i_abc.a), 1.0);
}

TEST(FaultInjection, TimesCountFromTheInjection) {
  const auto right = run(parameters(false));
  const auto jumped =
      run(parameters(true), {.kind = PlantFaultKind::speed_jump, .until_ns = 10 * period_ns, .jump = 7.0});
  for (std::size_t k = 0; k < periods; ++k) {
    // The plant stands at the read before when it is given the fault.
    const bool there = k >= begin && k < begin + 9;
    EXPECT_DOUBLE_EQ(jumped[k].omega_m, right[k].omega_m + (there ? 7.0 : 0.0)) << k;
  }
}

TEST(FaultInjection, TheLinkSagsAndAnOpenPhaseCarriesNoCurrent) {
  const auto sagged = run(parameters(true), {.kind = PlantFaultKind::link_sag, .sag_voltage = 300.0});
  EXPECT_EQ(sagged[begin - 1].u_dc, 530.0);
  EXPECT_EQ(sagged[begin].u_dc, 300.0);
  EXPECT_EQ(sagged[begin + 100].u_dc, 530.0);
  const auto open = run(parameters(true), {.kind = PlantFaultKind::open_phase, .phase = 0});
  for (std::size_t k = begin + 60; k < begin + 100; ++k) EXPECT_NEAR(open[k].i_abc.a, 0.0, 1e-9) << k;
  EXPECT_GT(std::abs(open[periods - 1].i_abc.a), 1.0);
}

}  // namespace
}  // namespace sextant
