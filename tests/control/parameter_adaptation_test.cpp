// The adaptation on machines that are known, whose fluxes and currents are complex numbers.
#include "sextant/control/parameter_adaptation.hpp"

#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

#include "control/drawn_machines.hpp"
#include "control/reference_machine.hpp"

namespace sextant {
namespace {

using Complex = std::complex<double>;
using Machine = InductionMachineParameters<double>;

constexpr Complex j{0, 1};
constexpr double update_time = 1e-3;

/// Errors of the sensors: of all currents, of all voltages. [-]
struct Gains {
  double current{1};
  double voltage{1};
};

/// What both models of a controller see of a machine whose rotor flux is held at 1 Wb while its torque steps,
/// in the frame of that flux. omega_r: speed of the rotor. [rad/s]
class TwoModels {
 public:
  TwoModels(const Machine& real, double omega_r, Gains gains)
      : real_{real}, omega_r_{omega_r}, gains_{gains} {}

  /// `believed`: the parameters of the controller; omega_s: slip frequency, by the torque. [rad/s]
  template <class T>
  typename ParameterAdaptation<T>::Evidence step(const Machine& believed, double omega_s) {
    const double omega_e = omega_r_ + omega_s;
    const Complex i_s = (1.0 + j * omega_s * real_.tau_r()) / real_.l_m;
    const Complex psi_s = real_.k_r() + real_.sigma_l_s() * i_s;
    const Complex i = gains_.current * i_s;
    const Complex pole = 1 / believed.tau_r() + j * omega_s;
    const Complex settled = believed.l_m * i / believed.tau_r() / pole;
    if (psi_r_ == Complex{}) psi_r_ = 1;
    psi_r_ = settled + (psi_r_ - settled) * std::exp(-pole * update_time);
    const Complex psi_cm = believed.k_r() * psi_r_ + believed.sigma_l_s() * i;
    const Complex voltage_drop = gains_.voltage * real_.r_s * i_s - believed.r_s * i;
    const Complex psi_v = gains_.voltage * psi_s + voltage_drop / (j * omega_e);
    constexpr double rate = 40;
    excess_ += (1 - std::exp(-rate * update_time)) * (psi_v / psi_cm - 1.0 - excess_);
    const auto vector = [](Complex x) { return SpaceVector<T>{T(x.real()), T(x.imag())}; };
    return {.excess = vector(excess_),
            .rates = {.follow = T(rate), .by_frequency = T(rate / omega_e), .leak = T(0)},
            .i_s = vector(i),
            .psi_r = vector(psi_r_),
            .psi_s = vector(psi_v),
            .present = test::converted<T>(believed),
            .steepness = T(0)};
  }

  /// Both models take over what an update has found.
  template <class T>
  void correct(const typename ParameterAdaptation<T>::Correction& correction) {
    psi_r_ *= 1.0 + Complex{double(correction.psi_r.alpha), double(correction.psi_r.beta)};
    excess_ -= Complex{double(correction.excess.alpha), double(correction.excess.beta)};
  }

 private:
  Machine real_;
  double omega_r_;
  Gains gains_;
  Complex psi_r_{};   ///< of the current model; at first that of the machine [Wb]
  Complex excess_{};  ///< c − 1 [-]
};

/// What an adaptation has found, and the deviation of R_s that it tells [-].
struct Followed {
  Machine machine;
  double r_s_deviation;
};

/// After that time of torque of both signs and none, each for 0.1 s; voltage_error [V].
template <class T>
Followed followed(const Machine& real, double omega_r, double seconds, double voltage_error,
                  Gains gains = {}) {
  TwoModels models{real, omega_r, gains};
  auto machine = test::converted<T>({});
  ParameterAdaptation<T> adaptation{machine, T(voltage_error)};
  for (int ms = 0; ms < int(seconds * 1e3); ++ms) {
    const double omega_s = 8.0 * (ms / 100 % 3 - 1);
    while (!adaptation.count(T(0.1 * update_time))) {
    }
    machine = adaptation.update(machine, models.step<T>(test::converted<double>(machine), omega_s));
    models.correct<T>(adaptation.correction());
  }
  return {test::converted<double>(machine), double(adaptation.covariance().deviations().r_s)};
}
/// The parameters, where the voltage is known.
template <class T>
Machine adapted(const Machine& real, double omega_r, double seconds, Gains gains = {}) {
  return followed<T>(real, omega_r, seconds, 0.0, gains).machine;
}

template <class T>
class ParameterAdaptationOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(ParameterAdaptationOf, Scalars);

TYPED_TEST(ParameterAdaptationOf, TorqueOfBothSignsTellsEveryParameter) {
  for (const double omega_r : {20.0, -40.0}) {
    for (const double r_s : {0.7, 1.0, 1.4}) {
      for (const double r_r : {0.7, 1.0, 1.4}) {
        for (const double l_m : {0.85, 1.15}) {
          SCOPED_TRACE(testing::Message() << omega_r << ' ' << r_s << ' ' << r_r << ' ' << l_m);
          Machine real;
          real.r_s *= r_s;
          real.r_r *= r_r;
          real.l_m *= l_m;
          const Machine found = adapted<TypeParam>(real, omega_r, 200);
          EXPECT_NEAR(found.r_s, real.r_s, 0.02 * real.r_s);
          EXPECT_NEAR(found.r_r, real.r_r, 0.02 * real.r_r);
          EXPECT_NEAR(found.l_m, real.l_m, 0.02 * real.l_m);
        }
      }
    }
  }
}

// What a voltage of 20 V may make of c is more than what an R_s that is 40 % larger makes: at 20 A that
// is 3.5 V. So c tells less of R_s, which remains less known.
TYPED_TEST(ParameterAdaptationOf, AnUnknownVoltageLeavesLessOfTheStatorResistanceToBeSeen) {
  using T = TypeParam;
  Machine real;
  real.r_s *= 1.4;
  const Followed known = followed<T>(real, 20, 3, 0.0);
  const Followed unknown = followed<T>(real, 20, 3, 20.0);
  EXPECT_NEAR(known.machine.r_s, real.r_s, 0.05 * real.r_s);
  EXPECT_LT(unknown.machine.r_s - Machine{}.r_s, 0.7 * (known.machine.r_s - Machine{}.r_s));
  EXPECT_GT(unknown.r_s_deviation, 1.5 * known.r_s_deviation);
}

TYPED_TEST(ParameterAdaptationOf, AKnownMachineStaysKnown) {
  const Machine real;
  const Machine found = adapted<TypeParam>(real, 40, 10);
  EXPECT_NEAR(found.r_s, real.r_s, 1e-4 * real.r_s);
  EXPECT_NEAR(found.r_r, real.r_r, 1e-4 * real.r_r);
  EXPECT_NEAR(found.l_m, real.l_m, 1e-4 * real.l_m);
}

// Equal gains of current and voltage are no change of any impedance; a gain of one of them is the same change
// of all, and no torque in parts of it.
// A gain of all currents or voltages is the same change of all impedances.
TYPED_TEST(ParameterAdaptationOf, AGainOfAllSensorsMovesTheParametersByNoMore) {
  const Machine real;
  for (const Gains gains :
       {Gains{1.02, 1}, Gains{0.98, 1}, Gains{1, 1.02}, Gains{1, 0.98}, Gains{1.02, 1.02}}) {
    SCOPED_TRACE(testing::Message() << gains.current << ' ' << gains.voltage);
    const double share = gains.voltage / gains.current;
    const Machine found = adapted<TypeParam>(real, 40, 300, gains);
    EXPECT_NEAR(found.r_s, share * real.r_s, 0.005 * real.r_s);
    EXPECT_NEAR(found.r_r, share * real.r_r, 0.005 * real.r_r);
    EXPECT_NEAR(found.l_m, share * real.l_m, 0.005 * real.l_m);
  }
}

// At 400 rad/s the resistive voltage is a hundredth of that of the flux.
TYPED_TEST(ParameterAdaptationOf, WhereItHasNoTraceTheStatorResistanceFollowsTheRotors) {
  Machine warm;
  warm.r_s *= 1.25;
  warm.r_r *= 1.25;
  const Machine found = adapted<TypeParam>(warm, 800, 30);
  const Machine m;
  EXPECT_NEAR(found.r_r, warm.r_r, 0.02 * m.r_r);
  EXPECT_GT(found.r_s, 1.05 * m.r_s);
  EXPECT_LT(found.r_s, 1.16 * m.r_s);
  Machine saturated;
  saturated.l_m *= 0.9;
  EXPECT_NEAR(adapted<TypeParam>(saturated, 800, 30).r_s, m.r_s, 0.01 * m.r_s);
}

TYPED_TEST(ParameterAdaptationOf, TheParametersStayWithinTheBoundsOfThePrior) {
  using T = TypeParam;
  const Machine m;
  for (const double factor : {5.0, 0.15}) {
    Machine real;
    real.r_s *= factor;
    real.r_r *= factor;
    real.l_m *= factor;
    const Machine found = adapted<T>(real, 20, 150);
    const double bound = factor > 1 ? 2.5 : 0.3;
    for (const double share : {found.r_s / m.r_s, found.r_r / m.r_r, found.l_m / m.l_m}) {
      EXPECT_GE(share, 0.2999);
      EXPECT_LE(share, 2.5001);
    }
    EXPECT_NEAR(found.l_m / m.l_m, bound, 1e-4);
  }
}

// The fluxes of both models differ at first where that from which they started was wrong.
TYPED_TEST(ParameterAdaptationOf, AWrongInitialFluxIsNoParameter) {
  using T = TypeParam;
  const auto m = test::converted<T>({});
  ParameterAdaptation<T> adaptation{m, T(0)};
  const Machine real;
  TwoModels models{real, 40, {}};
  auto machine = m;
  for (int ms = 0; ms < 50; ++ms) {
    while (!adaptation.count(T(0.1 * update_time))) {
    }
    auto seen = models.step<T>(real, 8);
    seen.excess = {T(0.3), T(0.3)};
    machine = adaptation.update(machine, seen);
  }
  EXPECT_NEAR(machine.r_s, m.r_s, T(0.005) * m.r_s);
  EXPECT_NEAR(machine.r_r, m.r_r, T(0.005) * m.r_r);
  EXPECT_NEAR(machine.l_m, m.l_m, T(0.005) * m.l_m);
}

/// After 0.1 to 30 s of torque at this speed, which changes every 0.1 s or is constant, with gains of this
/// deviation.
test::MachineCoverage coverage(unsigned seed, double omega_r, bool changes, double gain_deviation) {
  test::DrawnMachines drawn{seed};
  test::MachineCoverage out;
  for (int n = 0; n < 200; ++n) {
    const Machine real = drawn.next();
    const Gains gains{1 + gain_deviation * drawn.normal(), 1 + gain_deviation * drawn.normal()};
    TwoModels models{real, omega_r, gains};
    Machine machine;
    ParameterAdaptation<double> adaptation{machine, 0.0};
    for (int ms = 0, end = int(drawn.between(100, 30e3)); ms < end; ++ms) {
      while (!adaptation.count(0.1 * update_time)) {
      }
      machine =
          adaptation.update(machine, models.step<double>(machine, changes ? 8.0 * (ms / 100 % 3 - 1) : 6.0));
      models.correct<double>(adaptation.correction());
    }
    out.add(real, machine, adaptation.covariance().deviations());
  }
  return out;
}

// Prior deviations are 0.5, 0.25 and 0.15: what is told is less where the torque or the speed shows it.
TEST(ParameterAdaptationTells, HowFarTheParametersOfDrawnMachinesMayBeOff) {
  constexpr unsigned seed = 20240719;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const test::MachineCoverage slow = coverage(seed, 20, true, 0);
  slow.r_s.expect_honest("R_s at 20 rad/s", 0.1);
  slow.r_r.expect_honest("R_r at 20 rad/s", 0.2);
  slow.l_m.expect_honest("L_m at 20 rad/s", 0.06);
  const test::MachineCoverage fast = coverage(seed, 200, true, 0);
  fast.r_s.expect_honest("R_s at 200 rad/s", 0.5);
  fast.r_r.expect_honest("R_r at 200 rad/s", 0.15);
  fast.l_m.expect_honest("L_m at 200 rad/s", 0.06);
  const test::MachineCoverage constant = coverage(seed, 40, false, 0);
  constant.r_s.expect_honest("R_s under constant torque", 0.5);
  constant.r_r.expect_honest("R_r under constant torque", 0.15);
  constant.l_m.expect_honest("L_m under constant torque", 0.12);
  const test::MachineCoverage real_sensors = coverage(seed, 40, true, 0.02);
  real_sensors.r_s.expect_honest("R_s with gains of 2 %", 0.2);
  real_sensors.r_r.expect_honest("R_r with gains of 2 %", 0.2);
  real_sensors.l_m.expect_honest("L_m with gains of 2 %", 0.06);
}

// Of all gains it leaves the least: any other one leaves more, by Joseph's form, which holds for every gain.
TEST(ParameterCovarianceGain, LeavesTheLeastOfWhatIsUnknown) {
  constexpr unsigned seed = 20240811;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  const auto vector = [&] { return SpaceVector<double>{normal(random), normal(random)}; };
  using Covariance = ParameterCovariance<double>;
  for (int n = 0; n < 200; ++n) {
    Covariance p;
    const Covariance::Rows first{vector(), vector(), vector()};
    p.observe(first, p.gain(first, 0.05), 0.05);  // the parameters are correlated now
    const Covariance::Rows h{vector(), vector(), vector()};
    const double variance = std::exp(normal(random));
    const Covariance::Rows best = p.gain(h, variance);
    const auto left_by = [&](const Covariance::Rows& k) {
      Covariance after = p;
      after.observe(h, k, variance);
      return after.ss + after.rr + after.ll;
    };
    const double least = left_by(best);
    EXPECT_LT(least, p.ss + p.rr + p.ll);
    for (int other = 0; other < 10; ++other) {
      Covariance::Rows k = best;
      k.s += 0.05 * vector();
      k.r += 0.05 * vector();
      k.l += 0.05 * vector();
      EXPECT_GT(left_by(k), least);
    }
  }
}

TEST(ParameterAdaptationTells, ThatAMachineMayWarmWhileNothingIsSeenOfIt) {
  ParameterCovariance<double> known{.ss = 0, .sr = 0, .sl = 0, .rr = 0, .rl = 0, .ll = 0};
  for (int n = 0; n < 6000; ++n) known.age(0.1);
  const double warming = ParameterPrior<double>::warming;
  EXPECT_NEAR(known.deviations().r_s, std::hypot(warming, 0.03), 1e-9) << "600 s";
  EXPECT_NEAR(known.deviations().r_r, std::hypot(warming, 0.03), 1e-9);
  EXPECT_NEAR(known.deviations().l_m, 0.03, 1e-9) << "a gain of the sensors";
  for (int n = 0; n < 1'000'000; ++n) known.age(0.1);
  const auto most = ParameterCovariance<double>{}.deviations();
  EXPECT_LE(known.deviations().r_s, most.r_s);
  EXPECT_LE(known.deviations().r_r, most.r_r);
  EXPECT_NEAR(known.deviations().r_r, most.r_r, 0.01);
}

TYPED_TEST(ParameterAdaptationOf, WithoutFluxOrFrequencyNothingChanges) {
  using T = TypeParam;
  const auto m = test::converted<T>({});
  ParameterAdaptation<T> adaptation{m, T(0)};
  using Rates = typename ParameterAdaptation<T>::Rates;
  typename ParameterAdaptation<T>::Evidence seen{};
  seen.excess = {T(0.1), T(0.1)};
  seen.i_s = {T(10), T(0)};
  seen.present = m;
  for (const double flux : {0.0, 1e-20, 1.0}) {
    seen.psi_r = seen.psi_s = {T(flux), T(0)};
    seen.rates = flux < 1 ? Rates{T(10), T(10), T(0)} : Rates{T(0), T(0), T(10)};
    EXPECT_FALSE(adaptation.count(T(900e-6)));
    EXPECT_TRUE(adaptation.count(T(200e-6)));
    const auto after = adaptation.update(m, seen);
    EXPECT_EQ(after.r_s, m.r_s);
    EXPECT_EQ(after.r_r, m.r_r);
    EXPECT_EQ(after.l_m, m.l_m);
  }
}

// Without slip the flux goes with L_m at a given current; where it saturates with the steepness κ a share δ
// of L_m moves it by δ/(1 + κ), which is what the models are to take over.
TYPED_TEST(ParameterAdaptationOf, ASteepCurveLetsTheInductanceMoveTheFluxLess) {
  using T = TypeParam;
  const auto m = test::converted<T>({});
  for (const double steepness : {0.0, 3.5}) {
    ParameterAdaptation<T> adaptation{m, T(0)};
    const auto count = [&adaptation] {
      while (!adaptation.count(T(1.1e-3))) {
      }
    };
    const SpaceVector<T> psi_r{T(1), T(0)};
    const SpaceVector<T> i_s{T(1) / m.l_m, T(0)};
    for (int k = 0; k < 2000; ++k) {
      count();
      adaptation.magnetise(m, i_s, psi_r, T(steepness));
    }
    adaptation.begin_identified();
    const typename ParameterAdaptation<T>::Evidence seen{.excess = {T(0.1), T(0)},
                                                         .rates = {T(40), T(0), T(0)},
                                                         .i_s = i_s,
                                                         .psi_r = psi_r,
                                                         .psi_s = m.k_r() * psi_r + m.sigma_l_s() * i_s,
                                                         .present = m,
                                                         .steepness = T(steepness)};
    auto after = m;
    for (int k = 0; k < 20; ++k) {
      count();
      after = adaptation.update(m, seen);
    }
    const double share = double(after.l_m / m.l_m) - 1;
    EXPECT_GT(share, 1e-4);
    EXPECT_NEAR(double(adaptation.correction().psi_r.alpha) / share, 1 / (1 + steepness), 0.01);
  }
}

}  // namespace
}  // namespace sextant
