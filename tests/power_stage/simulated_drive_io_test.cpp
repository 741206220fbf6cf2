#include "sextant/power_stage/simulated_drive_io.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;
using Io = SimulatedDriveIo<Plant>;

constexpr std::int32_t period_ns = 25'000;

/// Integrates nothing, writes down what it was asked for, and fails when told to.
class RecordingIntegrator final : public PlantIntegrator<Plant> {
 public:
  struct Call {
    SwitchState state{};
    std::int64_t duration_ns{};
    double tau_l{};
  };
  bool advance(Plant& plant, std::int64_t duration_ns) noexcept override {
    if (fail) return false;
    calls.push_back({plant.inputs().state, duration_ns, plant.inputs().tau_l});
    return true;
  }
  void reset() noexcept override {}

  std::vector<Call> calls{};
  bool fail{false};
};

struct RecordedIo {
  explicit RecordedIo(const Io::Parameters& parameters = {},
                      const MechanicalLoad::Parameters& load_parameters = {})
      : load{load_parameters}, io{parameters, plant, integrator, load} {}
  MechanicalLoad load;
  Plant plant{DrivePlantParameters<double>{}};
  RecordingIntegrator integrator{};
  Io io;
};

struct PhysicalIo {
  explicit PhysicalIo(const Io::Parameters& parameters = {},
                      const MechanicalLoad::Parameters& load_parameters = {})
      : load{load_parameters}, io{parameters, plant, integrator, load} {}
  MechanicalLoad load;
  Plant plant{DrivePlantParameters<double>{}};
  FixedStepIntegrator<Plant> integrator{FixedStepParameters{}};
  Io io;
};

GatePattern vector(std::size_t n) {
  return {switch_states[n], period_ns};
}

void advance_to(Io& io, std::int64_t t_ns) {
  static_cast<void>(io.read(t_ns));
}

MechanicalLoad::Parameters load_torque_steps() {
  return {.load_torque = {.shape = ProfileShape::steps, .points = {{0.0, 2.0}, {60e-6, 7.0}, {1.0, 3.0}}}};
}

TEST(SimulatedDriveIo, GatesAreOffAtStartAndThePlantStaysAtRest) {
  PhysicalIo x;
  const Measurement<> first = x.io.read(0);
  EXPECT_EQ(first.applied.duration_ns(), 0);
  const Measurement<> second = x.io.read(period_ns);
  EXPECT_EQ(second.applied, (GatePattern{gates_off, period_ns}));
  EXPECT_EQ(second.i_abc, ThreePhase<double>{});
  EXPECT_EQ(second.omega_m, 0.0);
  EXPECT_TRUE(second.plausible);
}

// Estimator and metrics see a pattern through `applied` and the log of its segments.
TEST(SimulatedDriveIo, ASegmentWithoutDurationHasNoEffect) {
  RecordedIo x{{.hold_periods = 3}};
  advance_to(x.io, 0);
  GatePattern pattern;
  pattern.append({gates_off, 0});
  pattern.append({switch_states[1], 10'000});
  pattern.append({switch_states[4], 0});
  pattern.append({switch_states[2], 15'000});
  pattern.append({switch_states[0], 0});
  x.io.write(pattern);
  const Measurement<> m = x.io.read(2 * period_ns);
  GatePattern expected;
  expected.append({switch_states[1], 10'000});
  expected.append({switch_states[2], 15'000 + period_ns});
  EXPECT_EQ(m.applied, expected) << "the last segment with a duration is the one that is held";
  ASSERT_EQ(x.integrator.calls.size(), 2U);
  EXPECT_EQ(x.integrator.calls[0].state, switch_states[1]);
  EXPECT_EQ(x.integrator.calls[1].state, switch_states[2]);
}

// The measurement of a period is sampled at its beginning, before the pattern that is written for it.
TEST(SimulatedDriveIo, AMeasurementIsThatOfTheBeginningOfItsPeriod) {
  PhysicalIo x;
  advance_to(x.io, 0);
  x.io.write(vector(1));
  const double at_begin = x.plant.i_abc().a;
  EXPECT_EQ(at_begin, 0.0);
  const Measurement<> m = x.io.read(period_ns);
  x.io.write(vector(4));
  EXPECT_EQ(m.i_abc.a, x.plant.i_abc().a) << "the pattern that was written acts after the sample";
  EXPECT_GT(m.i_abc.a, 1.0);
}

TEST(SimulatedDriveIo, MeasuresTheRotorsAngleOnDemand) {
  const MechanicalLoad::Parameters speed{.imposed_speed = ProfileParameters{.value = 100}};
  PhysicalIo without{{}, speed};
  EXPECT_FALSE(without.io.read(0).theta_m.has_value());
  PhysicalIo with{{.measures_angle = true}, speed};
  EXPECT_EQ(with.io.read(0).theta_m, 0.0);
  ASSERT_TRUE(with.io.read(20'000'000).theta_m.has_value());
  EXPECT_NEAR(*with.io.read(20'000'000).theta_m, 2.0, 1e-9);
  EXPECT_NEAR(*with.io.read(40'000'000).theta_m, 4.0 - 2 * std::numbers::pi, 1e-9) << "wrapped";
}

TEST(SimulatedDriveIo, ThePlantMovesOnlyWhenItIsRead) {
  RecordedIo x;
  advance_to(x.io, -100'000);
  x.io.write(vector(1));
  EXPECT_TRUE(x.integrator.calls.empty());
  advance_to(x.io, -100'000 + period_ns);
  ASSERT_EQ(x.integrator.calls.size(), 1U);
  EXPECT_EQ(x.integrator.calls[0].duration_ns, period_ns);
  advance_to(x.io, -100'000 + period_ns);
  EXPECT_EQ(x.integrator.calls.size(), 1U) << "a second read of the same instant must not move the plant";
}

// Written in period k, V(k+1) acts in period k without delay and in period k+1 with one.
TEST(SimulatedDriveIo, ActuationDelayDecidesInWhichPeriodAPatternActs) {
  constexpr std::array<std::size_t, 4> written{1, 2, 3, 4};
  for (const int delay : {0, 1}) {
    SCOPED_TRACE(delay);
    RecordedIo x{{.actuation_delay_periods = delay}};
    std::vector<SwitchState> applied;
    for (std::size_t k = 0; k <= written.size(); ++k) {
      const Measurement<> m = x.io.read(std::int64_t(k) * period_ns);
      if (k > 0) applied.push_back(m.applied.last_state());
      if (k < written.size()) x.io.write(vector(written[k]));
    }
    const std::vector<SwitchState> without{switch_states[1], switch_states[2], switch_states[3],
                                           switch_states[4]};
    const std::vector<SwitchState> with{gates_off, switch_states[1], switch_states[2], switch_states[3]};
    EXPECT_EQ(applied, delay == 0 ? without : with);
    ASSERT_EQ(x.integrator.calls.size(), applied.size());
    for (std::size_t k = 0; k < applied.size(); ++k) EXPECT_EQ(x.integrator.calls[k].state, applied[k]);
  }
}

TEST(SimulatedDriveIo, APatternThatIsNotRenewedHoldsAndThenTheGatesTurnOff) {
  for (const int hold : {1, 3}) {
    SCOPED_TRACE(hold);
    RecordedIo x{{.hold_periods = hold}};
    advance_to(x.io, 0);
    GatePattern pattern{switch_states[2], 10'000};
    pattern.append({switch_states[1], 15'000});
    x.io.write(pattern);
    const Measurement<> m = x.io.read(10 * period_ns);
    const auto segments = m.applied.segments();
    ASSERT_EQ(segments.size(), 3U);
    EXPECT_EQ(segments[0], (GateSegment{switch_states[2], 10'000}));
    EXPECT_EQ(segments[1], (GateSegment{switch_states[1], hold * period_ns - 10'000}));
    EXPECT_EQ(segments[2], (GateSegment{gates_off, (10 - hold) * period_ns}));
  }
}

// A pattern may be cut short by an early read, empty, of any length that leaves room for one segment more, or
// stretched by a skip.
TEST(SimulatedDriveIo, AppliedCoversExactlyTheTimeThatPassedAndIsWhatThePlantSaw) {
  constexpr unsigned seed = 20260;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  const auto draw = [&random](int lo, int hi) { return std::uniform_int_distribution<int>{lo, hi}(random); };
  for (const int delay : {0, 1}) {
    RecordedIo x{{.actuation_delay_periods = delay, .hold_periods = draw(1, 4)}, load_torque_steps()};
    std::int64_t t = 0;
    advance_to(x.io, t);
    for (int n = 0; n < 5'000; ++n) {
      GatePattern pattern;
      const int segments = draw(0, int(GatePattern::capacity) - 1);
      for (int s = 0; s < segments; ++s)
        pattern.append({switch_states[std::size_t(draw(0, 7))], period_ns / segments});
      x.io.write(pattern);
      const std::int64_t elapsed = draw(0, 9) == 0 ? draw(1, 2'000'000) : period_ns;
      t += elapsed;
      x.integrator.calls.clear();
      const Measurement<> m = x.io.read(t);
      ASSERT_EQ(m.applied.duration_ns(), elapsed) << "read " << n;
      ASSERT_TRUE(m.plausible) << "read " << n;
      std::int64_t integrated = 0;
      for (const auto& call : x.integrator.calls) integrated += call.duration_ns;
      ASSERT_EQ(integrated, elapsed) << "read " << n;
    }
  }
}

TEST(SimulatedDriveIo, APatternOfSeveralSegmentsActsInItsOrder) {
  RecordedIo x;
  advance_to(x.io, 0);
  GatePattern pattern;
  for (const std::size_t n : {1U, 2U, 7U}) pattern.append({switch_states[n], n == 7U ? 5'000 : 10'000});
  x.io.write(pattern);
  const Measurement<> m = x.io.read(period_ns);
  EXPECT_EQ(m.applied, pattern);
  ASSERT_EQ(x.integrator.calls.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(x.integrator.calls[k].state, pattern.segments()[k].state);
    EXPECT_EQ(x.integrator.calls[k].duration_ns, pattern.segments()[k].duration_ns);
  }
}

TEST(SimulatedDriveIo, ALoadStepActsAtItsInstantAndNotAtTheNextRead) {
  RecordedIo x{{}, load_torque_steps()};
  advance_to(x.io, 0);
  x.io.write(vector(0));
  advance_to(x.io, 1'000'000);
  double impulse = 0.0;  // of the load torque [N·m·s]
  std::int64_t t = 0;
  for (const auto& call : x.integrator.calls) {
    impulse += call.tau_l * double(call.duration_ns) * 1e-9;
    EXPECT_EQ(call.tau_l, t < 60'000 ? 2.0 : 7.0) << "from " << t << " ns on";
    t += call.duration_ns;
  }
  EXPECT_NEAR(impulse, 2.0 * 60e-6 + 7.0 * 940e-6, 1e-15);
  EXPECT_EQ(x.io.tau_l(), 7.0);
}

// A free shaft under a load torque: omega_m is its impulse over J, also of a ramp with a corner in
// mid-period.
TEST(SimulatedDriveIo, TheShaftTakesTheExactImpulseOfARampedLoad) {
  PhysicalIo x{{}, {.load_torque = {.shape = ProfileShape::linear, .points = {{0.0, 0.0}, {310e-6, 62.0}}}}};
  for (int k = 0; k <= 40; ++k) advance_to(x.io, k * period_ns);
  const double impulse = 0.5 * 62.0 * 310e-6 + 62.0 * 690e-6;
  EXPECT_NEAR(x.io.read(1'000'000).omega_m, -impulse / InductionMachineParameters<>{}.inertia, 1e-9);
}

TEST(SimulatedDriveIo, ImposedSpeedFollowsItsProfileThroughCornersAndSkips) {
  const ProfileParameters speed{.shape = ProfileShape::linear,
                                .points = {{0.0, 20.0}, {0.00313, -35.0}, {0.00707, -35.0}, {0.01, 80.0}}};
  PhysicalIo x{{}, {.load_torque = {.value = 100.0}, .imposed_speed = speed}};
  const Profile profile{speed};
  constexpr unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::int64_t t = 0;
  while (t < 12'000'000) {
    EXPECT_NEAR(x.io.read(t).omega_m, profile.value(t), 1e-9) << "at " << t << " ns";
    x.io.write(vector(1 + random() % 6U));
    t += random() % 8U == 0 ? 20 * period_ns : period_ns;
  }
  advance_to(x.io, t);
  // The angle shows the speed between the reads as well.
  const double turned = 0.5 * (20.0 - 35.0) * 0.00313 - 35.0 * (0.00707 - 0.00313) +
                        0.5 * (-35.0 + 80.0) * (0.01 - 0.00707) + 80.0 * (double(t) * 1e-9 - 0.01);
  EXPECT_NEAR(x.io.plant().theta_m(), turned, 1e-9);
}

TEST(SimulatedDriveIo, AStepOfTheImposedSpeedActsAtItsInstantAndNotBefore) {
  const ProfileParameters speed{.shape = ProfileShape::steps, .points = {{0.0, 20.0}, {60e-6, 80.0}}};
  PhysicalIo x{{}, {.imposed_speed = speed}};
  const Profile profile{speed};
  for (int k = 0; k <= 8; ++k) {
    EXPECT_NEAR(x.io.read(k * period_ns).omega_m, profile.value(k * period_ns), 1e-9) << "period " << k;
  }
  EXPECT_NEAR(x.io.plant().theta_m(), 20.0 * 60e-6 + 80.0 * 140e-6, 1e-12);
}

// A live drive's clock counts from the start of the machine; a scenario's hand-shake comes before its zero.
TEST(SimulatedDriveIo, TheLoadCountsFromItsOriginWhateverTheClockSays) {
  constexpr std::int64_t uptime_ns = 400'000'000'000'000;
  const std::int64_t first_read_ns = uptime_ns - 50'000;
  const struct {
    std::optional<std::int64_t> origin_ns;
    std::int64_t zero_ns;  // of the profiles
  } cases[] = {{std::nullopt, first_read_ns}, {uptime_ns, uptime_ns}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.zero_ns);
    RecordedIo x{{.load_origin_ns = c.origin_ns}, load_torque_steps()};
    advance_to(x.io, first_read_ns);
    EXPECT_EQ(x.io.tau_l(), 2.0);
    for (int k = 1; k <= 8; ++k) advance_to(x.io, first_read_ns + k * period_ns);
    std::int64_t t = first_read_ns;
    for (const auto& call : x.integrator.calls) {
      EXPECT_EQ(call.tau_l, t < c.zero_ns + 60'000 ? 2.0 : 7.0)
          << t - first_read_ns << " ns after the first read";
      t += call.duration_ns;
    }
    EXPECT_EQ(x.io.tau_l(), 7.0);

    const ProfileParameters ramp{.shape = ProfileShape::linear, .points = {{0.0, 10.0}, {200e-6, 50.0}}};
    PhysicalIo y{{.load_origin_ns = c.origin_ns}, {.imposed_speed = ramp}};
    for (int k = 0; k <= 10; ++k) {
      const std::int64_t read_ns = first_read_ns + k * period_ns;
      EXPECT_NEAR(y.io.read(read_ns).omega_m, Profile{ramp}.value(read_ns - c.zero_ns), 1e-9);
    }
  }
}

// While the gates stay on, the voltage model with the reported pattern is exact but for the trapezoid of R·i.
TEST(SimulatedDriveIo, TheVoltageModelStaysOnThePlantsFluxThroughSkips) {
  constexpr unsigned seed = 99;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  PhysicalIo x{{.hold_periods = 3}, {.imposed_speed = ProfileParameters{.value = 40.0}}};
  FluxTorqueEstimator<double> estimator{{}};
  std::int64_t t = 0;
  estimator.step(x.io.read(t));
  for (int n = 0; n < 4'000; ++n) {
    const std::size_t active = 1 + std::size_t(n) / 67U % 6U;
    x.io.write(vector(random() % 4U == 0 ? active : 0U));
    t += random() % 10U == 0 ? 3 * period_ns : period_ns;
    estimator.step(x.io.read(t));
  }
  EXPECT_GT(magnitude(x.io.plant().psi_s()), 0.05) << "the run must have built up flux";
  EXPECT_LT(magnitude(estimator.psi_s() - x.io.plant().psi_s()), 2e-4);
}

TEST(SimulatedDriveIo, AfterAFailedIntegrationThePlantStandsStillAndSaysSo) {
  RecordedIo x;
  advance_to(x.io, 0);
  x.io.write(vector(1));
  EXPECT_TRUE(x.io.read(period_ns).plausible);
  x.integrator.fail = true;
  x.io.write(vector(1));
  const Plant::State before = x.plant.state();
  EXPECT_FALSE(x.io.read(2 * period_ns).plausible);
  EXPECT_FALSE(x.io.healthy());
  x.integrator.fail = false;
  const std::size_t calls = x.integrator.calls.size();
  for (int k = 3; k < 10; ++k) {
    x.io.write(vector(1));
    EXPECT_FALSE(x.io.read(k * period_ns).plausible);
  }
  EXPECT_EQ(x.integrator.calls.size(), calls) << "the integrator must not be asked again";
  EXPECT_EQ(x.plant.state(), before);
}

TEST(SimulatedDriveIo, TheAppliedPatternIsNotPlausibleWhereItCannotBeTold) {
  RecordedIo x;
  advance_to(x.io, 0);
  GatePattern full;
  for (std::size_t n = 0; n < GatePattern::capacity; ++n) full.append({switch_states[n], period_ns / 8});
  x.io.write(full);
  EXPECT_TRUE(x.io.read(period_ns).plausible);
  x.io.write(full);
  EXPECT_FALSE(x.io.read(3 * period_ns).plausible) << "no room for the gates that opened";
  x.io.write(vector(1));
  EXPECT_TRUE(x.io.read(4 * period_ns).plausible) << "the plant has caught up";
  EXPECT_FALSE(x.io.read(2'000'000'000).plausible) << "a gap too long to integrate at once";
}

TEST(SimulatedDriveIo, AStateThatIsNotFiniteIsNotPlausible) {
  RecordedIo x;
  advance_to(x.io, 0);
  x.plant.set_speed(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(x.io.read(period_ns).plausible);
}

TEST(SimulatedDriveIo, AStateThatTheLinkCannotFeedEndsThePlant) {
  RecordedIo x;
  advance_to(x.io, 0);
  x.io.write(vector(1));
  EXPECT_TRUE(x.io.read(period_ns).plausible);
  x.plant.set_fluxes({100.0, 0.0}, {99.0, 0.0});
  x.io.write(vector(1));
  EXPECT_FALSE(x.io.read(2 * period_ns).plausible);
  EXPECT_FALSE(x.io.healthy());
}

TEST(SimulatedDriveIo, RefusesParametersThatMakeNoPowerStage) {
  EXPECT_EQ(Io::Parameters{}.validate(), nullptr);
  EXPECT_NE((Io::Parameters{.period_ns = 0}.validate()), nullptr);
  EXPECT_NE((Io::Parameters{.u_dc = 0.0}.validate()), nullptr);
  EXPECT_NE((Io::Parameters{.u_dc = std::numeric_limits<double>::quiet_NaN()}.validate()), nullptr);
  EXPECT_NE((Io::Parameters{.actuation_delay_periods = 2}.validate()), nullptr);
  EXPECT_NE((Io::Parameters{.actuation_delay_periods = -1}.validate()), nullptr);
  EXPECT_NE((Io::Parameters{.hold_periods = 0}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
