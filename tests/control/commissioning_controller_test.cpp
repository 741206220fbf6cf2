// Commissioning closed around the reference machine, whose inverter here loses a voltage by its dead time.
#include "sextant/control/commissioning_controller.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"
#include "sextant/conformance/check_controller.hpp"

namespace sextant {
namespace {

constexpr double u_dc = 530;
constexpr double limit_a = 20;

/// A published level.
struct Published {
  double current;
  double voltage;
  double scatter;
  double drift;
};

/// A published block of a tone.
struct PublishedTone {
  double periods;                ///< of a cycle
  std::complex<double> current;  ///< [A]
  std::complex<double> voltage;  ///< [V]
  double speed;                  ///< [rad/s]
};

struct Seen {
  std::vector<Published> levels{};
  std::vector<PublishedTone> tones{};
  double least{1e9};  ///< of the current along phase a while tones are measured [A]
  double peak{};      ///< of |i_s| at the ends of periods [A]
  double last{};      ///< |i_s| at the end [A]
  double torque{};    ///< largest magnitude [N·m]
  bool finished{};
};

template <class T>
typename CommissioningController<T>::Parameters parameters(std::int32_t period_ns, int delay) {
  typename CommissioningController<T>::Parameters p;
  p.period_ns = period_ns;
  p.actuation_delay_periods = delay;
  p.highest_current = T(limit_a);
  p.levels = 3;
  p.hold_ns = 20'000'000;
  p.magnetiser = {.current_limit = T(40), .hand_over_current = T(30)};
  return p;
}

/// What the dead time takes from the stator voltage: the mean of each leg's sign(i_x) V. [V]
test::ReferenceMachine::Complex lost(const test::ReferenceMachine& machine, double v) {
  const auto i = machine.i_s();
  const double half_sqrt3 = 0.5 * std::sqrt(3.0);
  const double phases[] = {i.real(), -0.5 * i.real() + half_sqrt3 * i.imag(),
                           -0.5 * i.real() - half_sqrt3 * i.imag()};
  const auto sign = [](double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; };
  const auto a = std::polar(1.0, 2 * std::acos(-1.0) / 3);
  return 2.0 / 3.0 * v * (sign(phases[0]) + sign(phases[1]) * a + sign(phases[2]) * a * a);
}

/// A controller and the machine, period by period. The loss of the dead time acts as a kick of the stator
/// flux.
template <class T>
class Bench {
 public:
  Bench(const typename CommissioningController<T>::Parameters& p, double leg_volts,
        const InductionMachineParameters<double>& real = {})
      : machine{real, u_dc},
        controller{p},
        period_ns_{p.period_ns},
        delay_{p.actuation_delay_periods},
        leg_volts_{leg_volts},
        in_flight_{gates_off, p.period_ns},
        applied_{gates_off, p.period_ns} {}

  void step(ControlMode mode, T torque = T(0)) {
    const GatePattern decided = controller.step(machine.template measure<T>(applied_), {mode, torque, T(1)});
    applied_ = delay_ == 1 ? std::exchange(in_flight_, decided) : decided;
    if (!applied_.is_driven()) {
      machine.coast(period_ns_);
      return;
    }
    const auto kick = lost(machine, leg_volts_) * (period_ns_ * 1e-9);
    machine.psi_s -= 0.5 * kick;  // so that a reading is the mean of its surroundings
    machine.apply(applied_);
    machine.psi_s -= 0.5 * kick;
  }

  test::ReferenceMachine machine;
  CommissioningController<T> controller;

 private:
  std::int32_t period_ns_;
  int delay_;
  double leg_volts_;
  GatePattern in_flight_;
  GatePattern applied_;
};

template <class T>
Seen run(Bench<T>& bench, int periods, T torque = T(0)) {
  Seen seen;
  for (int k = 0; k < periods; ++k) {
    bench.step(ControlMode::torque, torque);
    seen.peak = std::max(seen.peak, std::abs(bench.machine.i_s()));
    seen.torque = std::max(seen.torque, std::abs(bench.machine.torque()));
    const auto values = bench.controller.channel_values();
    if (std::size_t(values[0]) == seen.levels.size() + 1) {
      seen.levels.push_back({values[3], values[4], values[6], values[7]});
      seen.tones.push_back({values[9], {values[10], values[11]}, {values[12], values[13]}, values[8]});
    }
    if (!seen.levels.empty() && !seen.finished) seen.least = std::min(seen.least, bench.machine.i_s().real());
    seen.finished = values[1] == T(1);
  }
  seen.last = std::abs(bench.machine.i_s());
  return seen;
}

constexpr int periods_of_all(std::int32_t period_ns) {
  return int((6 * (735 + 20) + 0.5 * 735) * 1e6 / period_ns);
}

template <class T>
class CommissioningOf : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(CommissioningOf, Scalars);

// Ohm's law and the voltage of the dead time, which the controller knows nothing of, in every level.
TYPED_TEST(CommissioningOf, PublishesTheVoltageThatResistanceAndInverterTake) {
  using T = TypeParam;
  const InductionMachineParameters<double> real{};
  for (const std::int32_t period_ns : {75'000, 125'000}) {
    const int delay = period_ns == 75'000 ? 1 : 0;
    SCOPED_TRACE(std::to_string(period_ns) + " ns, delay " + std::to_string(delay));
    const double leg_volts = u_dc * 1.5e-6 / (period_ns * 1e-9);
    Bench<T> bench{parameters<T>(period_ns, delay), leg_volts};
    const Seen seen = run(bench, periods_of_all(period_ns));
    ASSERT_EQ(seen.levels.size(), 6U);
    const double expected[] = {19, 11.4, 3.8, -3.8, -11.4, -19};
    for (std::size_t k = 0; k < 6; ++k) {
      const Published& level = seen.levels[k];
      const double sign = level.current > 0 ? 1 : -1;
      EXPECT_NEAR(level.current, expected[k], 0.05);
      EXPECT_NEAR(level.voltage, real.r_s * level.current + 4.0 / 3.0 * leg_volts * sign, 0.05);
      EXPECT_NEAR(level.drift, 0, 0.02);
    }
    EXPECT_TRUE(seen.finished);
    EXPECT_LT(seen.last, 0.3) << "it ends without current";
  }
}

// Whatever the controller believes of the leakage inductance and the rotor, and whatever torque is asked for.
TYPED_TEST(CommissioningOf, KeepsTheCurrentLimitAndMakesNoTorque) {
  using T = TypeParam;
  constexpr std::int32_t period_ns = 125'000;
  for (const double leakage : {0.5, 1.0, 2.0}) {
    for (const int delay : {0, 1}) {
      SCOPED_TRACE("leakage times " + std::to_string(leakage) + ", delay " + std::to_string(delay));
      InductionMachineParameters<double> real{};
      real.l_ls *= leakage;
      real.l_lr *= leakage;
      real.r_r *= leakage;
      Bench<T> bench{parameters<T>(period_ns, delay), u_dc * 3e-6 / (period_ns * 1e-9), real};
      const Seen seen = run(bench, periods_of_all(period_ns), T(60));
      EXPECT_EQ(seen.levels.size(), 6U);
      EXPECT_LE(seen.peak, limit_a);
      EXPECT_LT(seen.torque, 0.1);
    }
  }
}

TYPED_TEST(CommissioningOf, StopsAtOnceAndBeginsAnew) {
  using T = TypeParam;
  constexpr std::int32_t period_ns = 125'000;
  Bench<T> bench{parameters<T>(period_ns, 1), 10};
  Bench<T> fresh{parameters<T>(period_ns, 1), 10};
  const Seen first = run(bench, 9000);
  ASSERT_GE(first.levels.size(), 1U);
  const GatePattern off =
      bench.controller.step(bench.machine.template measure<T>({}), {ControlMode::off, 0, 1});
  EXPECT_FALSE(off.is_driven());
  for (const T value : bench.controller.channel_values()) EXPECT_EQ(value, T(0));
  for (int k = 0; k < 20'000; ++k) bench.step(ControlMode::off);  // the rotor flux decays
  const Seen again = run(bench, 9000);
  ASSERT_EQ(again.levels.size(), first.levels.size());
  EXPECT_NEAR(again.levels[0].voltage, first.levels[0].voltage, 0.01);
  bench.controller.reset();
  for (const T value : bench.controller.channel_values()) EXPECT_EQ(value, T(0));
}

/// σL_s and its like of the inverse-Γ circuit.
std::complex<double> impedance(const InductionMachineParameters<double>& m, double omega) {
  const std::complex<double> s{0, omega};
  const double ratio = m.l_m / m.l_r();
  const std::complex<double> magnetising = s * ratio * m.l_m;
  const double rotor = ratio * ratio * m.r_r;
  return m.r_s + s * (m.l_s() - ratio * m.l_m) + magnetising * rotor / (magnetising + rotor);
}

// The voltage acts half of a period after the reading on average, later by the delay: the phasors show the
// impedance, whatever the dead time takes. The sampled impedance deviates by (ωT)²/24 at most.
TYPED_TEST(CommissioningOf, TonesShowTheImpedanceAtStandstill) {
  using T = TypeParam;
  const InductionMachineParameters<double> real{};
  for (const int delay : {0, 1}) {
    SCOPED_TRACE("delay " + std::to_string(delay));
    constexpr std::int32_t period_ns = 125'000;
    auto p = parameters<T>(period_ns, delay);
    p.course = CommissioningCourse::tones;
    p.tones = 3;
    p.blocks = 2;
    p.lowest_frequency = T(20);
    p.highest_frequency = T(400);
    p.machine.l_m *= T(0.7);
    p.flux_reference = T(1.5);  // of more current than the limit
    Bench<T> bench{p, u_dc * 1.5e-6 / (period_ns * 1e-9)};
    const Seen seen = run(bench, 60'000);
    ASSERT_EQ(seen.tones.size(), 6U);
    for (const PublishedTone& tone : seen.tones) {
      const double omega = 2 * std::numbers::pi / (tone.periods * period_ns * 1e-9);
      const auto turned = std::polar(1.0, -omega * (0.5 + delay) * period_ns * 1e-9);
      const auto expected = impedance(real, omega);
      EXPECT_LT(std::abs(tone.voltage / tone.current * turned - expected), 2e-3 * std::abs(expected))
          << omega;
      EXPECT_NEAR(std::abs(tone.current), 0.4 * 0.95 * limit_a, 0.5);
      EXPECT_EQ(tone.speed, 0);
    }
    for (const Published& level : seen.levels) EXPECT_EQ(level.drift, 0) << "a cycle has no halves";
    EXPECT_NEAR(seen.tones.front().periods, 2 * std::numbers::pi / 20 / (period_ns * 1e-9), 1);
    EXPECT_NEAR(seen.tones.back().periods, 2 * std::numbers::pi / 400 / (period_ns * 1e-9), 1);
    EXPECT_GT(seen.least, 0.15 * limit_a) << "the current keeps its sign";
    EXPECT_LE(seen.peak, limit_a);
    EXPECT_LT(seen.torque, 0.1);
    EXPECT_TRUE(seen.finished);
  }
}

// Iron that saturates beyond the flux reference would show less leakage to a sine above that current.
TYPED_TEST(CommissioningOf, TonesTakeNoMoreFluxThanTheReference) {
  using T = TypeParam;
  auto p = parameters<T>(125'000, 0);
  p.course = CommissioningCourse::tones;
  p.tones = 2;
  p.blocks = 2;
  p.lowest_frequency = T(50);
  p.highest_frequency = T(400);
  p.highest_current = T(40);
  p.flux_reference = T(0.8);
  const double flux_current = 0.8 / InductionMachineParameters<double>{}.l_s();
  Bench<T> bench{p, 0};
  const Seen seen = run(bench, 60'000);
  ASSERT_TRUE(seen.finished);
  EXPECT_LE(seen.peak, flux_current);
  for (const PublishedTone& tone : seen.tones) {
    EXPECT_NEAR(std::abs(tone.current), 0.4 * 0.95 * flux_current, 0.03 * flux_current);
  }
}

// With levels so short that the random inputs of the check reach their ends.
TYPED_TEST(CommissioningOf, ConformsWhileLevelsEnd) {
  using T = TypeParam;
  typename CommissioningController<T>::Parameters p;
  p.settle_ns = 50'000;
  p.hold_ns = 100'000;
  p.lowest_frequency = T(2000);
  p.highest_frequency = T(8000);
  for (const CommissioningCourse course : {CommissioningCourse::levels, CommissioningCourse::tones}) {
    p.course = course;
    for (const std::uint64_t seed : {std::uint64_t{1}, std::uint64_t{std::random_device{}()}}) {
      const ConformanceResult result =
          check_controller<CommissioningController<T>, T>(p, {.seed = seed, .has_flux_reference = false});
      for (const std::string& violation : result.violations) ADD_FAILURE() << violation << ", seed " << seed;
    }
  }
}

TEST(Commissioning, RefusesParametersWithoutLevels) {
  const CommissioningController<double>::Parameters good = parameters<double>(25'000, 1);
  EXPECT_EQ(good.validate(), nullptr);
  const auto refused = [&good](auto change) {
    auto p = good;
    change(p);
    return p.validate() != nullptr;
  };
  EXPECT_TRUE(refused([](auto& p) { p.levels = 1; }));
  EXPECT_TRUE(refused([](auto& p) { p.highest_current = 0; }));
  EXPECT_TRUE(refused([](auto& p) { p.hold_ns = 25'000; }));
  EXPECT_TRUE(refused([](auto& p) { p.settle_ns = 0; }));
  EXPECT_TRUE(refused([](auto& p) { p.tones = 1; }));
  EXPECT_TRUE(refused([](auto& p) { p.blocks = 1; }));
  EXPECT_TRUE(refused([](auto& p) { p.lowest_frequency = 0; }));
  EXPECT_TRUE(refused([](auto& p) { p.lowest_frequency = 300; }));
  EXPECT_TRUE(refused([](auto& p) { p.highest_frequency = 20'000; }));
  EXPECT_TRUE(refused([](auto& p) { p.highest_frequency = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](auto& p) { p.settle_ns = std::int64_t{1} << 50; }));
}

}  // namespace
}  // namespace sextant
