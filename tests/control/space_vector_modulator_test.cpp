// The modulator against the volt-seconds of the two-level inverter.
#include "sextant/control/space_vector_modulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sextant/core/leg_duties.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr double u_dc = 530;

SpaceVector<double> mean_voltage(const GatePattern& pattern) {
  SpaceVector<double> sum{};
  for (const GateSegment& s : pattern.segments())
    sum += double(s.duration_ns) * stator_voltage(s.state, u_dc);
  return (1.0 / double(pattern.duration_ns())) * sum;
}

/// Of one period, from its first state to its last.
int commutations_within(const GatePattern& pattern) {
  int count = 0;
  for (std::size_t n = 1; n < pattern.segments().size(); ++n) {
    count += commutations(pattern.segments()[n - 1].state, pattern.segments()[n].state);
  }
  return count;
}

template <class T>
class SpaceVectorModulatorOf : public testing::Test {
 protected:
  /// Calls body(u) for vectors of that many lengths in all directions, up to `longest`. [V]
  template <class Body>
  static void for_vectors(double longest, const Body& body) {
    for (int n = 0; n <= 8; ++n) {
      for (int degrees = -180; degrees < 180; degrees += 5) {
        const double theta = (degrees + 0.3) * std::numbers::pi / 180;
        SCOPED_TRACE(testing::Message() << n << " of 8 at " << degrees);
        body(SpaceVector<T>{T(longest * n / 8 * std::cos(theta)), T(longest * n / 8 * std::sin(theta))});
      }
    }
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SpaceVectorModulatorOf, Scalars);

// Whole nanoseconds: an edge is wrong by up to 1 ns of 25 µs at 530 V.
constexpr double rounding = 2.0 * u_dc / period_ns;

TYPED_TEST(SpaceVectorModulatorOf, TheMeanVoltageIsTheOneDemanded) {
  using T = TypeParam;
  for (const PatternKind kind : {PatternKind::symmetric, PatternKind::asymmetric}) {
    for (const ZeroVectors zero :
         {ZeroVectors::both, ZeroVectors::low, ZeroVectors::high, ZeroVectors::alternating}) {
      SpaceVectorModulator<T> modulator{{.pattern = kind, .zero_vectors = zero}};
      this->for_vectors(0.999 * u_dc / std::numbers::sqrt3, [&](SpaceVector<T> u) {
        const GatePattern pattern = modulator.step(u, T(u_dc), period_ns);
        EXPECT_EQ(pattern.duration_ns(), period_ns);
        EXPECT_NEAR(mean_voltage(pattern).alpha, double(u.alpha), rounding);
        EXPECT_NEAR(mean_voltage(pattern).beta, double(u.beta), rounding);
      });
    }
  }
}

// d_x = 1/2 + (u_x − (max u + min u)/2)/u_dc: J. Holtz, "Pulsewidth modulation: a survey", IEEE Trans. Ind.
// Electron. 39 (1992) 410–420.
TYPED_TEST(SpaceVectorModulatorOf, TheDutyCyclesAreThoseOfTheCarrierWithTheMeanOfItsExtremes) {
  using T = TypeParam;
  for (const PatternKind kind : {PatternKind::symmetric, PatternKind::asymmetric}) {
    SpaceVectorModulator<T> modulator{{.pattern = kind}};
    this->for_vectors(0.999 * u_dc / std::numbers::sqrt3, [&](SpaceVector<T> u) {
      const ThreePhase<T> d = leg_duties<T>(modulator.step(u, T(u_dc), period_ns));
      const ThreePhase<double> v = inverse_clarke(SpaceVector<double>{double(u.alpha), double(u.beta)});
      const double middle = 0.5 * (std::max({v.a, v.b, v.c}) + std::min({v.a, v.b, v.c}));
      EXPECT_NEAR(double(d.a), 0.5 + (v.a - middle) / u_dc, 2.0 / period_ns);
      EXPECT_NEAR(double(d.b), 0.5 + (v.b - middle) / u_dc, 2.0 / period_ns);
      EXPECT_NEAR(double(d.c), 0.5 + (v.c - middle) / u_dc, 2.0 / period_ns);
    });
  }
}

TYPED_TEST(SpaceVectorModulatorOf, ASymmetricPatternIsTheSameBackwards) {
  using T = TypeParam;
  SpaceVectorModulator<T> modulator{{}};
  this->for_vectors(300, [&](SpaceVector<T> u) {
    const GatePattern pattern = modulator.step(u, T(u_dc), period_ns);
    const auto s = pattern.segments();
    for (std::size_t n = 0; n < s.size(); ++n) {
      EXPECT_EQ(s[n].state, s[s.size() - 1 - n].state);
      EXPECT_NEAR(s[n].duration_ns, s[s.size() - 1 - n].duration_ns, 1);
    }
  });
}

// One leg at a time; six edges a period, four where a leg rests, half of them in asymmetric patterns.
TYPED_TEST(SpaceVectorModulatorOf, SwitchesAsRarelyAsItsKindAllows) {
  using T = TypeParam;
  const auto edges = [](PatternKind kind, ZeroVectors zero) {
    SpaceVectorModulator<T> modulator{{.pattern = kind, .zero_vectors = zero}};
    int count = 0;
    SwitchState last = switch_states[0];
    for (int k = 0; k < 20; ++k) {
      const GatePattern p = modulator.step({T(150), T(80)}, T(u_dc), period_ns);
      for (const GateSegment& s : p.segments()) {
        EXPECT_LE(commutations(last, s.state), k == 0 ? 3 : 1);
        count += k < 10 ? 0 : commutations(last, s.state);
        last = s.state;
      }
    }
    return count / 10.0;
  };
  EXPECT_EQ(edges(PatternKind::symmetric, ZeroVectors::both), 6);
  EXPECT_EQ(edges(PatternKind::symmetric, ZeroVectors::low), 4);
  EXPECT_EQ(edges(PatternKind::symmetric, ZeroVectors::high), 4);
  EXPECT_EQ(edges(PatternKind::symmetric, ZeroVectors::alternating), 4);
  EXPECT_EQ(edges(PatternKind::asymmetric, ZeroVectors::both), 3);
  EXPECT_EQ(edges(PatternKind::asymmetric, ZeroVectors::low), 2);
}

TYPED_TEST(SpaceVectorModulatorOf, BeyondTheHexagonTheNearestVoltageOrTheOneInTheSameDirection) {
  using T = TypeParam;
  SpaceVectorModulator<T> nearest{{.overmodulation = Overmodulation::magnitude}};
  SpaceVectorModulator<T> direct{{.overmodulation = Overmodulation::angle}};
  this->for_vectors(900, [&](SpaceVector<T> u) {
    const SpaceVector<double> wanted{double(u.alpha), double(u.beta)};
    const SpaceVector<double> near = mean_voltage(nearest.step(u, T(u_dc), period_ns));
    const SpaceVector<double> along = mean_voltage(direct.step(u, T(u_dc), period_ns));
    EXPECT_NEAR(cross(along, wanted) / std::max(1.0, magnitude(wanted)), 0, 2 * rounding);
    EXPECT_LE(magnitude(wanted - near), magnitude(wanted - along) + 2 * rounding);
    // No point of the hexagon's boundary is nearer.
    for (int n = 1; n <= 6; ++n) {
      const SpaceVector<double> corner = stator_voltage(switch_states[std::size_t(n)], u_dc);
      const SpaceVector<double> next = stator_voltage(switch_states[std::size_t(n % 6 + 1)], u_dc);
      for (int k = 0; k <= 20; ++k) {
        const SpaceVector<double> edge = corner + k / 20.0 * (next - corner);
        EXPECT_LE(magnitude(wanted - near), magnitude(wanted - edge) + 2 * rounding);
      }
    }
  });
}

TYPED_TEST(SpaceVectorModulatorOf, ALongVoltageIsOneVectorOfSixStep) {
  using T = TypeParam;
  SpaceVectorModulator<T> modulator{{}};
  for (int n = 1; n <= 6; ++n) {
    const SpaceVector<T> u = T(20) * stator_voltage(switch_states[std::size_t(n)], T(u_dc));
    const GatePattern pattern = modulator.step(u, T(u_dc), period_ns);
    EXPECT_EQ(commutations_within(pattern), 0);
    EXPECT_EQ(pattern.last_state(), switch_states[std::size_t(n)]);
  }
}

TYPED_TEST(SpaceVectorModulatorOf, TellsTheVoltageThatThePatternHas) {
  using T = TypeParam;
  for (const Overmodulation o : {Overmodulation::angle, Overmodulation::magnitude}) {
    SpaceVectorModulator<T> modulator{{.overmodulation = o}};
    this->for_vectors(700, [&](SpaceVector<T> u) {
      const SpaceVector<T> told = modulator.within_hexagon(u, T(u_dc));
      const SpaceVector<double> real = mean_voltage(modulator.step(u, T(u_dc), period_ns));
      EXPECT_NEAR(double(told.alpha), real.alpha, rounding);
      EXPECT_NEAR(double(told.beta), real.beta, rounding);
    });
  }
}

/// Fundamental of the voltages that take the place of a demand while it turns. [V]
template <class T>
std::complex<double> turning(const SpaceVectorModulator<T>& modulator, double demand, int samples) {
  std::complex<double> sum{};
  for (int k = 0; k < samples; ++k) {
    const std::complex<double> along = std::polar(1.0, 2 * std::numbers::pi * (k + 0.5) / samples);
    const SpaceVector<T> u =
        modulator.mean_voltage({T(demand * along.real()), T(demand * along.imag())}, T(u_dc));
    sum += std::complex<double>{double(u.alpha), double(u.beta)} * std::conj(along);
  }
  return sum / double(samples);
}

TYPED_TEST(SpaceVectorModulatorOf, TheFundamentalIsTheDemandUpToThatOfSixStep) {
  using T = TypeParam;
  const SpaceVectorModulator<T> modulator{{.overmodulation = Overmodulation::fundamental}};
  const double six_step = 2 / std::numbers::pi * u_dc;
  for (int n = 0; n <= 120; ++n) {
    const double demand = 300 + 0.5 * n;
    const double expected = std::min(demand, six_step);
    EXPECT_LT(std::abs(turning(modulator, demand, 7200) - expected), 0.003) << demand;
    const SpaceVector<T> told = modulator.fundamental({T(demand * 0.6), T(-demand * 0.8)}, T(u_dc));
    EXPECT_NEAR(double(told.alpha), 0.6 * expected, 1e-3);
    EXPECT_NEAR(double(told.beta), -0.8 * expected, 1e-3);
  }
}

// All of it is within the hexagon, and patterns have it.
TYPED_TEST(SpaceVectorModulatorOf, TheVoltagesOfAFundamentalArePossible) {
  using T = TypeParam;
  SpaceVectorModulator<T> modulator{{.overmodulation = Overmodulation::fundamental}};
  this->for_vectors(400, [&](SpaceVector<T> u) {
    const SpaceVector<T> wanted = modulator.mean_voltage(u, T(u_dc));
    const SpaceVector<double> real = mean_voltage(modulator.step(wanted, T(u_dc), period_ns));
    EXPECT_NEAR(double(wanted.alpha), real.alpha, rounding);
    EXPECT_NEAR(double(wanted.beta), real.beta, rounding);
    if (magnitude(u) < T(u_dc / std::numbers::sqrt3)) {
      EXPECT_NEAR(double(u.alpha), real.alpha, rounding);
      EXPECT_NEAR(double(u.beta), real.beta, rounding);
    }
  });
}

// Drivers that leave out short pulses take the voltage of half of one at most.
TYPED_TEST(SpaceVectorModulatorOf, AMinimumPulseLeavesTheFundamentalOfOvermodulation) {
  using T = TypeParam;
  constexpr std::int32_t minimum_ns = 1'000;
  constexpr int samples = 1'200;
  SpaceVectorModulator<T> modulator{
      {.overmodulation = Overmodulation::fundamental, .minimum_pulse_ns = minimum_ns}};
  for (const double demand : {310.0, 320.0, 330.0, 336.0}) {
    std::complex<double> sum{};
    for (int k = 0; k < samples; ++k) {
      const std::complex<double> along = std::polar(1.0, 2 * std::numbers::pi * (k + 0.5) / samples);
      const SpaceVector<T> u =
          modulator.mean_voltage({T(demand * along.real()), T(demand * along.imag())}, T(u_dc));
      const SpaceVector<double> real = mean_voltage(modulator.step(u, T(u_dc), period_ns));
      sum += std::complex<double>{real.alpha, real.beta} * std::conj(along);
    }
    EXPECT_LT(std::abs(sum / double(samples) - demand), 0.5 * minimum_ns / period_ns * u_dc) << demand;
  }
}

// The error of the voltage stays below what half of the shortest pulse of a leg is worth.
TYPED_TEST(SpaceVectorModulatorOf, NoLegIsHighOrLowForLessThanTheShortestPulse) {
  using T = TypeParam;
  constexpr std::int32_t shortest_ns = 1'000;
  for (const ZeroVectors zero : {ZeroVectors::both, ZeroVectors::low, ZeroVectors::alternating}) {
    SpaceVectorModulator<T> modulator{{.zero_vectors = zero, .shortest_pulse_ns = shortest_ns}};
    this->for_vectors(350, [&](SpaceVector<T> u) {
      const GatePattern pattern = modulator.step(u, T(u_dc), period_ns);
      EXPECT_EQ(pattern.duration_ns(), period_ns);
      for (unsigned leg = 0; leg < 3; ++leg) {
        std::int32_t high_ns = 0;
        for (const GateSegment& s : pattern.segments()) {
          if ((s.state.upper_switches() >> leg & 1U) != 0U) high_ns += s.duration_ns;
        }
        EXPECT_TRUE(high_ns == 0 || high_ns == period_ns ||
                    (high_ns >= shortest_ns && high_ns <= period_ns - shortest_ns))
            << high_ns;
      }
      const SpaceVector<T> within = modulator.within_hexagon(u, T(u_dc));
      const SpaceVector<double> wanted{double(within.alpha), double(within.beta)};
      EXPECT_LE(magnitude(mean_voltage(pattern) - wanted), 1.01 * u_dc * shortest_ns / period_ns);
    });
  }
}

using Random = std::mt19937;

/// A voltage up to 1.1 times the longest one, and corrections as of dead times.
struct Demand {
  SpaceVector<double> u;      ///< [V]
  ThreePhase<double> longer;  ///< [s]
};
Demand random_demand(Random& random) {
  std::uniform_real_distribution<double> theta{-std::numbers::pi, std::numbers::pi};
  std::uniform_real_distribution<double> length{0, 1.1 * u_dc * 2 / 3};
  std::uniform_real_distribution<double> longer{-2e-6, 2e-6};
  const double size = length(random);
  const double angle = theta(random);
  return {{size * std::cos(angle), size * std::sin(angle)}, {longer(random), longer(random), longer(random)}};
}

// Also where a leg rests in one of two periods that follow each other.
TYPED_TEST(SpaceVectorModulatorOf, NoPulseIsShorterThanTheMinimumPulseAcrossPeriodsEither) {
  using T = TypeParam;
  constexpr std::int32_t minimum_ns = 1'501;
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random{seed};
  for (const PatternKind kind : {PatternKind::symmetric, PatternKind::asymmetric}) {
    for (const ZeroVectors zero :
         {ZeroVectors::both, ZeroVectors::low, ZeroVectors::high, ZeroVectors::alternating}) {
      SpaceVectorModulator<T> modulator{
          {.pattern = kind, .zero_vectors = zero, .minimum_pulse_ns = minimum_ns}};
      std::array<std::int64_t, 3> lasted{minimum_ns, minimum_ns, minimum_ns};
      unsigned last = 0;
      for (int k = 0; k < 20'000; ++k) {
        const Demand d = random_demand(random);
        const GatePattern pattern = modulator.step({T(d.u.alpha), T(d.u.beta)}, T(u_dc), period_ns,
                                                   {T(d.longer.a), T(d.longer.b), T(d.longer.c)});
        ASSERT_EQ(pattern.duration_ns(), period_ns);
        for (const GateSegment& s : pattern.segments()) {
          const unsigned now = s.state.upper_switches();
          for (unsigned n = 0; n < 3; ++n) {
            if (((now ^ last) >> n & 1U) != 0U) {
              ASSERT_GE(lasted[n], minimum_ns) << "period " << k << ", leg " << n;
              lasted[n] = 0;
            }
            lasted[n] += s.duration_ns;
          }
          last = now;
        }
      }
    }
  }
}

/// The least error that a pattern can have whose legs are admissible, over all high times of one leg in steps
/// of 10 ns. [V]
double least_error(SpaceVector<double> u, std::int32_t shortest_high, std::int32_t shortest_low) {
  const ThreePhase<double> v = inverse_clarke(u);
  const auto nearest = [&](double ns) {
    double found = ns < 0.5 * period_ns ? 0 : period_ns;
    const double inside = std::clamp(ns, double(shortest_high), double(period_ns - shortest_low));
    return std::abs(inside - ns) < std::abs(found - ns) ? inside : found;
  };
  const auto duty = [](double volts) { return volts / u_dc * period_ns; };
  const double lowest = duty(std::min({v.a, v.b, v.c}));
  const double highest = duty(std::max({v.a, v.b, v.c}));
  double least = period_ns;
  for (double shift = -lowest; shift <= period_ns - highest + 1; shift += 10) {
    const auto missed = [&](double volts) { return nearest(duty(volts) + shift) - duty(volts) - shift; };
    const ThreePhase<double> e{missed(v.a), missed(v.b), missed(v.c)};
    least = std::min(least, std::max({e.a, e.b, e.c}) - std::min({e.a, e.b, e.c}));
  }
  return least / period_ns * u_dc;
}

// The zero vectors take up what a minimum pulse would take, as far as they can.
TYPED_TEST(SpaceVectorModulatorOf, AMinimumPulseLeavesTheLeastErrorThatAnyZeroVectorsWouldLeave) {
  using T = TypeParam;
  constexpr std::int32_t minimum_ns = 1'000;
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random{seed};
  int exact = 0;
  int inexact = 0;
  for (const ZeroVectors zero : {ZeroVectors::both, ZeroVectors::low, ZeroVectors::alternating}) {
    SpaceVectorModulator<T> modulator{{.zero_vectors = zero, .minimum_pulse_ns = minimum_ns}};
    for (int k = 0; k < 3'000; ++k) {
      const SpaceVector<T> demanded{T(random_demand(random).u.alpha), T(random_demand(random).u.beta)};
      const SpaceVector<T> within = modulator.within_hexagon(demanded, T(u_dc));
      const SpaceVector<double> u{double(within.alpha), double(within.beta)};
      const SpaceVector<double> missed = mean_voltage(modulator.step(demanded, T(u_dc), period_ns)) - u;
      const ThreePhase<double> e = inverse_clarke(missed);
      const double error = std::max({e.a, e.b, e.c}) - std::min({e.a, e.b, e.c});
      const double least = least_error(u, minimum_ns, 2 * minimum_ns + 3);
      double most = least;
      // Where a leg is as near to rest as to a pulse, the rounding of the times may decide.
      for (const int off_ns : {-4, 4})
        most = std::max(most, least_error(u, minimum_ns + off_ns, 2 * minimum_ns + 3 + off_ns));
      ASSERT_LE(error, most + 3 * rounding + 10 * u_dc / period_ns) << u.alpha << ", " << u.beta;
      (least < rounding ? exact : inexact) += 1;
    }
  }
  EXPECT_GT(exact, 3'000);
  EXPECT_GT(inexact, 100);
}

std::int32_t high_ns(const GatePattern& pattern, unsigned leg) {
  std::int32_t sum = 0;
  for (const GateSegment& s : pattern.segments()) {
    if ((s.state.upper_switches() >> leg & 1U) != 0U) sum += s.duration_ns;
  }
  return sum;
}

/// The voltage by which the legs are high for these times, and as much longer or shorter together. [V]
template <class T>
SpaceVector<T> voltage_of(const ThreePhase<double>& ns) {
  const SpaceVector<double> u = (u_dc / period_ns) * clarke(ns);
  return {T(u.alpha), T(u.beta)};
}

// Of the zero vectors that leave no error those are taken which are nearest to what is demanded.
TYPED_TEST(SpaceVectorModulatorOf, TheZeroVectorsMoveByNoMoreThanAMinimumPulseNeeds) {
  using T = TypeParam;
  SpaceVectorModulator<T> low{{.zero_vectors = ZeroVectors::low, .minimum_pulse_ns = 1'000}};
  const GatePattern pattern = low.step(voltage_of<T>({10'000, 300, 0}), T(u_dc), period_ns);
  EXPECT_NEAR(high_ns(pattern, 0), 11'000, 1);
  EXPECT_NEAR(high_ns(pattern, 1), 1'300, 1);
  EXPECT_NEAR(high_ns(pattern, 2), 1'000, 1);

  // A correction by 200 ns beyond the period, of which the leg is to be low for 103 ns.
  SpaceVectorModulator<T> both{{.minimum_pulse_ns = 50}};
  const ThreePhase<double> wanted{period_ns - 1'000, 5'000, 1'000};
  const GatePattern corrected =
      both.step(voltage_of<T>(wanted), T(u_dc), period_ns, {T(1'200e-9), T(0), T(0)});
  EXPECT_NEAR(high_ns(corrected, 0), period_ns - 103, 1);
  EXPECT_NEAR(high_ns(corrected, 1), 5'000 - 303, 1);
  EXPECT_NEAR(high_ns(corrected, 2), 1'000 - 303, 1);
}

TYPED_TEST(SpaceVectorModulatorOf, ACorrectionLengthensTheHighTimeOfLegsThatSwitch) {
  using T = TypeParam;
  SpaceVectorModulator<T> modulator{{.zero_vectors = ZeroVectors::low}};
  const SpaceVector<T> u{T(150), T(80)};
  const GatePattern plain = modulator.step(u, T(u_dc), period_ns);
  const GatePattern corrected = modulator.step(u, T(u_dc), period_ns, {T(200e-9), T(-300e-9), T(500e-9)});
  EXPECT_NEAR(high_ns(corrected, 0) - high_ns(plain, 0), 200, 1);
  EXPECT_NEAR(high_ns(corrected, 1) - high_ns(plain, 1), -300, 1);
  EXPECT_EQ(high_ns(corrected, 2), 0) << "it rests low";
}

// A small voltage, whose active vectors are shorter than what dead times take: the order of the legs' edges
// is that of their corrected times.
TYPED_TEST(SpaceVectorModulatorOf, ACorrectionMayExchangeTheOrderOfTheLegs) {
  using T = TypeParam;
  for (const PatternKind kind : {PatternKind::symmetric, PatternKind::asymmetric}) {
    SpaceVectorModulator<T> modulator{{.pattern = kind}};
    this->for_vectors(8, [&](SpaceVector<T> u) {
      const ThreePhase<T> longer{T(-1.5e-6), T(1.5e-6), T(0.5e-6)};
      const SpaceVector<T> added = (T(u_dc) / T(period_ns * 1e-9)) * clarke(longer);
      const GatePattern pattern = modulator.step(u, T(u_dc), period_ns, longer);
      EXPECT_NEAR(mean_voltage(pattern).alpha, double(u.alpha + added.alpha), 2 * rounding);
      EXPECT_NEAR(mean_voltage(pattern).beta, double(u.beta + added.beta), 2 * rounding);
    });
  }
}

TYPED_TEST(SpaceVectorModulatorOf, AnyInputGivesAPatternThatFillsThePeriod) {
  using T = TypeParam;
  constexpr unsigned seed = 20261123;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 generator{seed};
  std::uniform_real_distribution<double> exponent{-30, 30};
  std::uniform_int_distribution<int> pick{0, 9};
  const auto number = [&] {
    const int kind = pick(generator);
    if (kind == 0) return T(0);
    if (kind == 1) return std::numeric_limits<T>::max();
    if (kind == 2) return std::numeric_limits<T>::quiet_NaN();
    return T((kind % 2 == 0 ? 1 : -1) * std::pow(10.0, exponent(generator)));
  };
  SpaceVectorModulator<T> modulator{{.pattern = PatternKind::asymmetric, .shortest_pulse_ns = 700}};
  for (int k = 0; k < 20'000; ++k) {
    const GatePattern pattern = modulator.step({number(), number()}, number(), period_ns);
    ASSERT_EQ(pattern.duration_ns(), period_ns);
    ASSERT_TRUE(pattern.is_driven());
    for (const GateSegment& s : pattern.segments()) ASSERT_GE(s.duration_ns, 0);
  }
}

TYPED_TEST(SpaceVectorModulatorOf, RefusesANegativePulse) {
  using Parameters = typename SpaceVectorModulator<TypeParam>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  EXPECT_NE((Parameters{.shortest_pulse_ns = -1}.validate()), nullptr);
  EXPECT_NE((Parameters{.minimum_pulse_ns = -1}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
