#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/event_exact/cvode_event_engine.hpp"
#include "sextant/event_exact/event_exact_simulation.hpp"
#include "sextant/event_exact/fixed_step_event_engine.hpp"

namespace sextant {
namespace {

struct Edge {
  double t;  // [s]
  SwitchState state;
};

struct RunToEdges {
  DrivePlantParameters<> plant{};
  DirectTorqueController<>::Parameters control{};
  double torque{15};         // [N·m]
  double omega_m{30};        // [rad/s]
  double initial_flux{1.1};  // [Wb]
  std::size_t edges{1000};

  template <class Engine>
  [[nodiscard]] std::vector<Edge> operator()(Engine&& engine) const {
    EventExactSystem system{plant, control, 1e-3};
    if (initial_flux > 0) system.magnetise(initial_flux);
    system.set_speed(omega_m);
    EventExactSimulation<std::remove_reference_t<Engine>> simulation{{}, system, engine};
    std::vector<Edge> found;
    double t = 0;
    while (found.size() < edges) {
      const bool good = simulation.run(
          {.duration_ns = 1'000'000, .torque_reference = torque, .u_dc = 530, .imposed_speed = true},
          [&t](double duration) {
            t += duration;
            return true;
          },
          [&] { found.push_back({t, system.comparators().state()}); });
      if (!good) break;
    }
    found.resize(std::min(found.size(), edges));
    return found;
  }
};

CvodeParameters tolerance(double relative) {
  CvodeParameters p{};
  p.relative_tolerance = relative;
  p.flux_tolerance = 1e-2 * relative;
  p.speed_tolerance = 1e-8;
  return p;
}

/// Largest distance of the edges in time [s]; infinite where their sequence differs.
double distance(const std::vector<Edge>& a, const std::vector<Edge>& b) {
  double worst = 0;
  if (a.size() != b.size() || a.empty()) return INFINITY;
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (a[k].state != b[k].state) return INFINITY;
    worst = std::max(worst, std::abs(a[k].t - b[k].t));
  }
  return worst;
}

TEST(EventEngines, FixedStepAndCvodeSwitchTheSameThousandTimes) {
  const RunToEdges run;
  const auto fixed = run(FixedStepEventEngine{5e-6});
  ASSERT_EQ(fixed.size(), 1000U);
  EXPECT_LT(distance(fixed, run(CvodeEventEngine{tolerance(1e-11), 20e-6})), 1e-9);
  // At 1e-8 the local errors of CVODE add up to tens of nanoseconds, the sequence is the same.
  EXPECT_LT(distance(fixed, run(CvodeEventEngine{tolerance(1e-8), 20e-6})), 100e-9);
}

TEST(EventEngines, AStartFromADeadMachineIsTheSameToo) {
  RunToEdges run;
  run.initial_flux = 0;
  EXPECT_LT(distance(run(FixedStepEventEngine{5e-6}), run(CvodeEventEngine{tolerance(1e-11), 20e-6})), 1e-9);
}

TEST(EventEngines, TheStepOfTheFixedStepEngineHardlyMatters) {
  const RunToEdges run;
  const auto reference = run(FixedStepEventEngine{2e-6});
  EXPECT_LT(distance(reference, run(FixedStepEventEngine{10e-6})), 1e-11);
  EXPECT_LT(distance(reference, run(FixedStepEventEngine{20e-6})), 1e-10);
}

/// With neither resistance nor speed the flux grows on a straight line, |ψ̂_s| = 2/3 u_dc t.
TEST(EventEngines, AnEventComesAtItsAnalyticInstant) {
  DrivePlantParameters<> plant;
  DirectTorqueController<>::Parameters control;
  control.machine.r_s = 0;
  constexpr double mask = 0.02;
  for (const bool cvode : {false, true}) {
    EventExactSystem system{plant, control, mask};
    system.set_surroundings(530, 0, true, 0);
    system.set_reference(15, 0);
    ASSERT_TRUE(system.settle(-1)) << "a torque reference takes an active vector";
    EventPiece piece;
    double t = 0;
    CvodeEventEngine by_cvode{tolerance(1e-10), 20e-6};
    FixedStepEventEngine by_steps{20e-6};
    do {
      piece = cvode ? by_cvode.advance(system, 1e-3, true) : by_steps.advance(system, 1e-3, true);
      t += piece.duration;
    } while (piece.outcome == EventOutcome::reached && t < 1e-3);
    ASSERT_EQ(piece.outcome, EventOutcome::event);
    EXPECT_EQ(piece.event, ContinuousComparators::mask);
    EXPECT_NEAR(t, mask / (2.0 / 3 * 530), 1e-13) << (cvode ? "CVODE" : "fixed step");
  }
}

TEST(EventEngines, WithoutDetectionTheyRunPastEvents) {
  DirectTorqueController<>::Parameters control;
  EventExactSystem system{{}, control, 1e-3};
  system.set_surroundings(530, 0, true, 0);
  system.set_reference(15, 0);
  system.settle(-1);
  FixedStepEventEngine engine{20e-6};
  EXPECT_EQ(engine.advance(system, 20e-6, false).outcome, EventOutcome::reached);
  EXPECT_LT(system.comparators().event(ContinuousComparators::mask, {system.estimated_flux(), 0, 15}), 0);
}

TEST(EventEngines, AStateThatIsNotFiniteFails) {
  DirectTorqueController<>::Parameters control;
  EventExactSystem system{{}, control, 1e-3};
  system.set_surroundings(530, 0, true, 0);
  system.magnetise(NAN);
  EXPECT_EQ((FixedStepEventEngine{20e-6}.advance(system, 1e-6, true).outcome), EventOutcome::failed);
  EXPECT_EQ((CvodeEventEngine{{}, 20e-6}.advance(system, 1e-6, true).outcome), EventOutcome::failed);
}

}  // namespace
}  // namespace sextant
