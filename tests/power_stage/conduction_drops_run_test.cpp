// The drops of the simulated inverter against their analytic law: a leg that carries i_x lacks
// sign(i_x) V_t + r i_x of its mean voltage, whatever its pattern is, and with a dead time sign(i_x) u_dc t_d
// of its volt-seconds in a period beside.
#include <array>
#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr double period_s = 25e-6;
constexpr double u_dc = 530.0;
constexpr ConductionDrops<double> drops{.threshold_voltage = 1.2, .slope_resistance = 0.02};

/// Each leg rises once and falls once.
GatePattern modulated() {
  GatePattern p;
  const std::array<std::size_t, 7> order{0, 1, 2, 7, 2, 1, 0};
  const std::array<std::int32_t, 7> times{4'000, 2'500, 3'000, 6'000, 3'000, 2'500, 4'000};
  for (std::size_t n = 0; n < 7; ++n) p.append({switch_states[order[n]], times[n]});
  return p;
}

/// Change of the stator flux over a period of the pattern that follows one of a zero vector, from these phase
/// currents at standstill. [Wb]
SpaceVector<> flux_change(IntegratorKind integrator, std::int32_t dead_time_ns,
                          const ConductionDrops<double>& of, const ThreePhase<>& i) {
  using Stage = SimulatedPowerStage;
  Stage::Parameters parameters;
  parameters.integrator = integrator;
  parameters.io.u_dc = u_dc;
  parameters.io.dead_time_ns = dead_time_ns;
  parameters.plant.drops = of;
  parameters.cvode.relative_tolerance = parameters.erk.relative_tolerance = 1e-9;
  const MechanicalLoad standstill{{.imposed_speed = ProfileParameters{.value = 0.0}}};
  Stage::Plant plant{parameters.plant};
  const auto moves = Stage::make_integrator(parameters);
  Stage::Io io{parameters.io, plant, *moves, standstill};
  static_cast<void>(io.read(0));
  io.write({switch_states[0], period_ns});
  static_cast<void>(io.read(period_ns));
  const SpaceVector<> i_s = clarke(i);
  const InductionMachineParameters<> m = parameters.plant.machine;
  // No rotor current: the flux of the stator current in both windings.
  plant.set_fluxes(m.l_s() * i_s, m.l_m * i_s);
  const SpaceVector<> before = plant.psi_s();
  io.write(modulated());
  EXPECT_TRUE(io.read(2 * period_ns).plausible);
  return plant.psi_s() - before;
}

struct Case {
  ThreePhase<> i;     ///< [A]
  ThreePhase<> sign;  ///< of the currents
};
constexpr std::array<Case, 4> cases{{{{20, -8, -12}, {1, -1, -1}},
                                     {{-20, 8, 12}, {-1, 1, 1}},
                                     {{9, 14, -23}, {1, 1, -1}},
                                     {{-9, 20, -11}, {-1, 1, -1}}}};
constexpr std::array<IntegratorKind, 4> integrators{IntegratorKind::fixed, IntegratorKind::exact,
                                                    IntegratorKind::cvode, IntegratorKind::erk};

TEST(ConductionDropsRun, ALegLacksThresholdAndSlopeOfItsMeanVoltage) {
  for (const IntegratorKind integrator : integrators) {
    for (const Case& c : cases) {
      SCOPED_TRACE(testing::Message() << "integrator " << int(integrator) << ", i_a " << c.i.a);
      const SpaceVector<> expected =
          period_s * (drops.threshold_voltage * clarke(c.sign) + drops.slope_resistance * clarke(c.i));
      const SpaceVector<> lost = flux_change(integrator, 0, {}, c.i) - flux_change(integrator, 0, drops, c.i);
      // The currents move by some A in the period.
      EXPECT_LT(magnitude(lost - expected), 0.02 * magnitude(expected));
    }
  }
}

TEST(ConductionDropsRun, DropsAndDeadTimeAddUp) {
  constexpr std::int32_t dead_ns = 1'500;
  for (const IntegratorKind integrator : integrators) {
    for (const Case& c : cases) {
      SCOPED_TRACE(testing::Message() << "integrator " << int(integrator) << ", i_a " << c.i.a);
      const SpaceVector<> of_drops =
          period_s * (drops.threshold_voltage * clarke(c.sign) + drops.slope_resistance * clarke(c.i));
      const SpaceVector<> expected = of_drops + (u_dc * dead_ns * 1e-9) * clarke(c.sign);
      const SpaceVector<> lost =
          flux_change(integrator, 0, {}, c.i) - flux_change(integrator, dead_ns, drops, c.i);
      EXPECT_LT(magnitude(lost - expected), 4e-3 * magnitude(expected));
      EXPECT_GT(magnitude(of_drops), 0.03 * magnitude(expected));
    }
  }
}

}  // namespace
}  // namespace sextant
