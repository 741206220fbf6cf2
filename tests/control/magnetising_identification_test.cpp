// Identification while the machine is magnetised, on courses of machines that are known: the flux of a
// constant current along it, the voltages that belong to it.
#include "sextant/control/magnetising_identification.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "control/drawn_machines.hpp"
#include "control/reference_machine.hpp"

namespace sextant {
namespace {

using Machine = InductionMachineParameters<double>;

/// From 250 W to 200 kW, rotor time constants from 52 ms to 0.81 s.
const Machine machines[] = {{},
                            {25, 22, 0.06, 0.06, 1.1, 2},
                            {0.057, 0.0316, 1.12e-3, 1.12e-3, 25.6e-3, 2},
                            {6.32e-5, 7.75e-5, 1.31e-6, 1.03e-6, 3.88e-5, 4},
                            {0.012, 0.009, 1.4e-4, 1.6e-4, 5.2e-3, 3}};

/// φ = k_r ψ_r of a machine by a constant current of 1 A, from zero. [Wb]
class Course {
 public:
  explicit Course(const Machine& m) : m_{m} {}
  [[nodiscard]] double flux(double t) const { return final() * (1 - std::exp(-t / m_.tau_r())); }
  [[nodiscard]] double slope(double t) const { return (final() - flux(t)) / m_.tau_r(); }
  [[nodiscard]] double final() const { return m_.k_r() * m_.l_m; }

 private:
  Machine m_;
};

/// What a run of the identification shows.
struct Shown {
  double worst{};               ///< largest |φ_estimated − φ|/φ_final from 0.2 τ_r on [-]
  double last{};                ///< the same at the hand-over [-]
  Machine found{};              ///< after `finish`
  double lowest_quotient{1e9};  ///< of the estimated flux and the current model's [-]
  double highest_quotient{};    ///< [-]
  bool has_found{};
  ParameterDeviations<double> told{};
};

/// Magnetises for 0.8 τ_r a machine that the identification believes to be `believed`, at the speed
/// omega_r(t) [rad/s].
template <class T>
Shown magnetise(const Machine& real, const Machine& believed, const std::function<double(double)>& omega_r) {
  MagnetisingIdentification<T> identification{test::converted<T>(believed), T(0), T(1.1)};
  const Course course{real};
  const Course model{believed};
  const double dt = real.tau_r() / 5000;
  const double end = 0.8 * real.tau_r();
  Shown shown;
  identification.begin(T(0), T(omega_r(0)));
  const auto error = [&](double t) {
    return std::abs(double(identification.flux()) - course.flux(t)) / course.final();
  };
  double t = 0;
  while (t < end) {
    const double middle = t + dt / 2;
    t += dt;
    identification.step({T(real.r_s + course.slope(middle)), T(omega_r(middle) * course.flux(middle))},
                        {T(1), T(0)}, T(model.flux(t)), T(omega_r(middle)), T(dt));
    if (t < 0.2 * real.tau_r()) continue;
    shown.worst = std::max(shown.worst, error(t));
    const double quotient = double(identification.flux()) / model.flux(t);
    shown.lowest_quotient = std::min(shown.lowest_quotient, quotient);
    shown.highest_quotient = std::max(shown.highest_quotient, quotient);
  }
  const auto found = identification.finish(test::converted<T>(believed));
  shown.found = test::converted<double>(found);
  shown.has_found = identification.has_found();
  const auto told = identification.covariance().deviations();
  shown.told = {double(told.r_s), double(told.r_r), double(told.l_m)};
  shown.last = error(t);
  return shown;
}

void expect_same(const Machine& found, const Machine& expected) {
  EXPECT_NEAR(found.r_s / expected.r_s, 1, 1e-6);
  EXPECT_NEAR(found.r_r / expected.r_r, 1, 1e-6);
  EXPECT_NEAR(found.l_m / expected.l_m, 1, 1e-6);
}

template <class T>
class MagnetisingIdentificationOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(MagnetisingIdentificationOf, Scalars);

/// A shaft that passes through standstill at a share of τ_r, from a multiple of R_s/L_s.
std::function<double(double)> passing(const Machine& m, double corners, double at) {
  const double from = corners * m.r_s / m.l_s();
  return [from, passage = at * m.tau_r()](double t) { return from * (1 - t / passage); };
}

TYPED_TEST(MagnetisingIdentificationOf, KeepsTheFluxOfAKnownMachineWhileTheShaftPassesThroughStandstill) {
  for (const Machine& m : machines) {
    for (const double corners : {-300.0, -30.0, -3.0, 1.0, 10.0, 100.0}) {
      for (const double at : {0.1, 0.3, 0.5, 0.7, 0.75, 0.79, 0.9}) {
        const Shown shown = magnetise<TypeParam>(m, m, passing(m, corners, at));
        EXPECT_LT(shown.worst, 0.005) << m.r_s << " ohm, " << corners << " corners, at " << at;
        EXPECT_LT(shown.last, 0.005) << m.r_s << " ohm, " << corners << " corners, at " << at;
      }
    }
  }
}

TYPED_TEST(MagnetisingIdentificationOf, TakesNoParameterOverFromAPassageThroughStandstill) {
  const Machine believed;
  Machine real = believed;
  real.r_r *= 1.3;
  real.r_s *= 0.8;
  for (const double corners : {-30.0, 3.0, 30.0, 300.0}) {
    for (const double at : {0.3, 0.5, 0.7}) {
      SCOPED_TRACE(testing::Message() << corners << " corners, at " << at);
      expect_same(magnetise<TypeParam>(real, believed, passing(real, corners, at)).found, believed);
    }
  }
}

// Of the same machine without a passage, at a constant and at a changing speed.
TYPED_TEST(MagnetisingIdentificationOf, FindsAMachineThatTurnsInOneDirection) {
  const Machine believed;
  Machine real = believed;
  real.r_r *= 1.3;
  for (const double at : {1e9, -3.0, 3.0}) {
    SCOPED_TRACE(at);
    const Shown shown = magnetise<TypeParam>(real, believed, passing(believed, 30, at));
    EXPECT_NEAR(shown.found.r_r / real.r_r, 1, 0.13);
    EXPECT_LT(shown.last, 0.02);
  }
}

/// The frame of a known machine at a constant current is behind its flux by `angle` [rad].
template <class T>
SpaceVector<double> direction_seen(const Machine& m, double r_s, double omega_r, double angle) {
  MagnetisingIdentification<T> identification{test::converted<T>(m), T(0), T(1.1)};
  const Course course{m};
  const double dt = m.tau_r() / 5000;
  identification.begin(T(0), T(omega_r));
  for (double t = 0; t < 0.8 * m.tau_r(); t += dt) {
    const double rise = course.slope(t + dt / 2), emf = omega_r * course.flux(t + dt / 2);
    identification.step({T(r_s + rise * std::cos(angle) - emf * std::sin(angle)),
                         T(rise * std::sin(angle) + emf * std::cos(angle))},
                        {T(1), T(0)}, T(course.flux(t + dt)), T(omega_r), T(dt));
  }
  const SpaceVector<T> seen = identification.direction();
  return {double(seen.alpha), double(seen.beta)};
}

// A speed that is read late turns the frame. What the resistances may be wrong by, up to 2.5 times, stays
// unknown of the angle.
TYPED_TEST(MagnetisingIdentificationOf, FindsTheDirectionOfTheFluxInAFrameThatIsBehind) {
  for (const Machine& m : machines) {
    for (const double corners : {-300.0, -30.0, 30.0, 300.0}) {
      const double omega_r = corners * m.r_s / m.l_s();
      const double unknown = 2.5 * (m.r_s + m.r_r) / std::abs(omega_r * Course{m}.flux(0.7 * m.tau_r()));
      for (const double angle : {-0.3, -0.1, 0.1, 0.3}) {
        const SpaceVector<double> seen = direction_seen<TypeParam>(m, m.r_s, omega_r, angle);
        EXPECT_NEAR(std::atan2(seen.beta, seen.alpha), angle, 0.02 + unknown)
            << m.r_s << " ohm, " << corners << " corners";
      }
    }
  }
}

// A frame that takes each turn comes to its flux, from whichever side, and does not pass it by much.
TYPED_TEST(MagnetisingIdentificationOf, TurnsAFrameThatIsBehindToItsFlux) {
  using T = TypeParam;
  for (const Machine& m : machines) {
    for (const double corners : {-300.0, 300.0}) {
      const double omega_r = corners * m.r_s / m.l_s();
      const double unknown = 2.5 * (m.r_s + m.r_r) / std::abs(omega_r * Course{m}.flux(0.7 * m.tau_r()));
      for (const double first : {-0.3, 0.3}) {
        SCOPED_TRACE(testing::Message() << m.r_s << " ohm, " << corners << " corners, " << first);
        MagnetisingIdentification<T> identification{test::converted<T>(m), T(0), T(1.1)};
        const Course course{m};
        const double dt = m.tau_r() / 5000;
        identification.begin(T(0), T(omega_r));
        double angle = first;
        double opposite = 0;
        for (double t = 0; t < 0.8 * m.tau_r(); t += dt) {
          const double rise = course.slope(t + dt / 2), emf = omega_r * course.flux(t + dt / 2);
          identification.step({T(m.r_s + rise * std::cos(angle) - emf * std::sin(angle)),
                               T(rise * std::sin(angle) + emf * std::cos(angle))},
                              {T(1), T(0)}, T(course.flux(t + dt)), T(omega_r), T(dt));
          const SpaceVector<T> turn = identification.turn(T(dt));
          angle -= std::atan2(double(turn.beta), double(turn.alpha));
          opposite = std::max(opposite, angle / -first);
        }
        EXPECT_LT(std::abs(angle), 0.02 + unknown);
        EXPECT_LT(opposite, 0.25);
      }
    }
  }
}

TYPED_TEST(MagnetisingIdentificationOf, AStatorResistanceWithinTheBoundsIsNoAngle) {
  for (const Machine& m : machines) {
    for (const double corners : {-300.0, -3.0, 0.0, 3.0, 300.0}) {
      for (const double share : {0.5, 1.0, 2.0}) {
        const SpaceVector<double> seen =
            direction_seen<TypeParam>(m, share * m.r_s, corners * m.r_s / m.l_s(), 0.0);
        EXPECT_EQ(seen.alpha, 1) << m.r_s << " ohm, " << corners << " corners, " << share;
        EXPECT_EQ(seen.beta, 0) << m.r_s << " ohm, " << corners << " corners, " << share;
      }
    }
  }
}

// Prior deviations are 0.5, 0.25 and 0.15.
TYPED_TEST(MagnetisingIdentificationOf, TellsHowFarTheParametersOfDrawnMachinesMayBeOff) {
  constexpr unsigned seed = 20240720;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  for (const bool turns : {false, true}) {
    test::DrawnMachines drawn{seed};
    test::MachineCoverage coverage;
    const Machine believed;
    for (int n = 0; n < 200; ++n) {
      const Machine real = drawn.next();
      const double omega_r = turns ? drawn.between(5, 100) * believed.r_s / believed.l_s() : 0;
      const Shown shown = magnetise<TypeParam>(real, believed, [omega_r](double) { return omega_r; });
      if (shown.has_found) coverage.add(real, shown.found, shown.told);
    }
    coverage.r_s.expect_honest(turns ? "R_s, turning" : "R_s, still", 0.18);
    coverage.r_r.expect_honest(turns ? "R_r, turning" : "R_r, still", 0.15);
    coverage.l_m.expect_honest(turns ? "L_m, turning" : "L_m, still", 0.17);
  }
}

// A voltage across the flux that is 3 V off is a flux that is 0.1 Wb off at 30 rad/s. Where the voltage may
// be off by 20 V the flux is that of the current model there.
TYPED_TEST(MagnetisingIdentificationOf, AVoltageThatMayBeOffDoesNotShowTheFlux) {
  using T = TypeParam;
  const Machine m;
  constexpr double omega_r = 30;
  constexpr double dt = 1e-4;
  const auto error_of = [&](double voltage_error) {
    MagnetisingIdentification<T> identification{test::converted<T>(m), T(voltage_error), T(1.1)};
    identification.begin(T(1), T(omega_r));
    for (int k = 0; k < 2000; ++k) {
      identification.step({T(m.r_s * 13), T(omega_r + 3)}, {T(13), T(0)}, T(1), T(omega_r), T(dt));
    }
    return double(identification.flux()) - 1;
  };
  EXPECT_NEAR(error_of(0), 3 / omega_r, 0.01);
  EXPECT_NEAR(error_of(20), 0, 0.01);
}

// By a machine whose parameters are within the bounds of the prior the current allows no flux beyond them.
TYPED_TEST(MagnetisingIdentificationOf, HandsOverNoFluxThatTheCurrentDoesNotAllow) {
  using Prior = ParameterPrior<double>;
  for (const double factor : {0.1, 0.31, 2.4, 8.0}) {
    const Machine believed;
    Machine real = believed;
    real.r_r *= factor;
    real.l_m *= factor;
    for (const double at : {0.3, 0.7, 1e9}) {
      const Shown shown = magnetise<TypeParam>(real, believed, passing(believed, 30, at));
      EXPECT_GE(shown.lowest_quotient, 0.999 * Prior::lowest) << factor << ", passage at " << at;
      EXPECT_LE(shown.highest_quotient, 1.001 * Prior::highest) << factor << ", passage at " << at;
    }
  }
}

TYPED_TEST(MagnetisingIdentificationOf, OfACourseBeyondTheBoundsNothingIsTakenOver) {
  const Machine believed;
  Machine real = believed;
  real.r_r *= 4;
  real.l_m *= 4;
  real.r_s *= 0.6;
  const Shown shown = magnetise<TypeParam>(real, believed, passing(believed, 30, 1e9));
  expect_same(shown.found, believed);
}

// A voltage along the current that the applied patterns do not show, as dead time makes one, passes for a
// resistance of the stator: beyond its bound neither the parameters nor the flux of the course count.
TYPED_TEST(MagnetisingIdentificationOf, AVoltageThatIsNoneOfAMachineChangesNothing) {
  const Machine believed;
  for (const double speed : {0.0, 10.0, 30.0}) {
    for (const double factor : {4.0, 10.0, 0.1}) {
      SCOPED_TRACE(testing::Message() << "R_s by " << factor << " at " << speed << " rad/s");
      Machine real = believed;
      real.r_s *= factor;
      const Shown shown = magnetise<TypeParam>(real, believed, [speed](double) { return speed; });
      expect_same(shown.found, believed);
      EXPECT_FALSE(shown.has_found);
      EXPECT_LT(shown.last, 0.01);
    }
  }
}

}  // namespace
}  // namespace sextant
