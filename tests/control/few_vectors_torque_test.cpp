// Mean torque of the methods that take one of few vectors a period, with periods in which a vector changes
// much of it, and the defaults that follow from that change.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/control/duty_ratio_controller.hpp"
#include "sextant/control/predictive_controller.hpp"
#include "sextant/control/vector_torque.hpp"

namespace sextant {
namespace {

using Machine = InductionMachineParameters<double>;

/// The machine of configs/machines/krause_3hp.toml, at whose rated flux a vector moves 5.4 % of it in 125 µs.
const Machine krause{0.435, 0.816, 2e-3, 2e-3, 69.31e-3, 2, 0.089};
constexpr double psi_ref = 0.476;
constexpr double u_dc = 311;
constexpr double rated = 12.5;  ///< torque [N·m]

/// A controller closed around its machine, whose shaft turns as imposed.
template <class C>
class Closed {
 public:
  using Parameters = typename C::Parameters;

  explicit Closed(const Parameters& p)
      : machine{p.machine, u_dc},
        period_ns_{p.period_ns},
        delay_{p.actuation_delay_periods},
        controller_{p} {}

  void step(ControlMode mode, double torque) {
    const GatePattern decided = controller_.step(machine.measure<double>(applied_), {mode, torque, 1.0});
    applied_ = delay_ > 0 ? std::exchange(waiting_, decided) : decided;
    if (is_driven(applied_.last_state())) {
      machine.apply(applied_);
    } else {
      applied_ = GatePattern{gates_off, period_ns_};
      machine.coast(period_ns_);
    }
  }

  [[nodiscard]] bool magnetise() {
    for (int k = 0; k < 20'000; ++k) {
      step(ControlMode::magnetise, 0);
      if (controller_.estimate().magnetised) return true;
    }
    return false;
  }

  test::ReferenceMachine machine;

 private:
  std::int32_t period_ns_;
  int delay_;
  C controller_;
  GatePattern waiting_{gates_off, period_ns_};
  GatePattern applied_{gates_off, period_ns_};
};

template <class C>
typename C::Parameters parameters_of(std::int32_t period_ns, int delay) {
  typename C::Parameters p;
  p.machine = krause;
  p.flux_reference = psi_ref;
  p.period_ns = period_ns;
  p.actuation_delay_periods = delay;
  const double current = psi_ref / krause.l_s();
  p.magnetiser = {.current_limit = 1.8 * current, .hand_over_current = 1.25 * current};
  return p;
}

/// Largest deviation of the mean torque of 20 ms from its reference while the shaft passes standstill. [N·m]
template <class C>
double worst_mean(const typename C::Parameters& p, double torque, double speed) {
  Closed<C> loop{p};
  loop.machine.omega_m = -speed;
  EXPECT_TRUE(loop.magnetise());
  const int periods = int(400'000'000 / p.period_ns);
  const auto span = std::size_t(20'000'000 / p.period_ns);
  std::deque<double> last;
  double sum = 0;
  double worst = 0;
  double before = loop.machine.torque();
  for (int k = 0; k < periods; ++k) {
    loop.machine.omega_m = speed * (2.0 * k / periods - 1);
    loop.step(ControlMode::torque, torque);
    last.push_back(0.5 * (before + loop.machine.torque()));
    sum += last.back();
    before = loop.machine.torque();
    if (last.size() <= span) continue;
    sum -= last.front();
    last.pop_front();
    if (k >= int(3 * span / 2)) worst = std::max(worst, std::abs(sum / double(span) - torque));
  }
  return worst;
}

/// Torque within periods against its reference, at constant speed. [N·m]
struct Steady {
  double rms{};
  double bias{};
};

template <class C>
Steady steady(const typename C::Parameters& p, double torque, double omega_m) {
  Closed<C> loop{p};
  loop.machine.omega_m = omega_m;
  EXPECT_TRUE(loop.magnetise());
  const auto run = [&](int ms) {
    for (int k = 0; k < ms * 1'000'000 / p.period_ns; ++k) loop.step(ControlMode::torque, torque);
  };
  run(200);
  double time = 0;
  double squares = 0;
  double sum = 0;
  loop.machine.on_part = [&](double dt) {
    const double error = loop.machine.torque() - torque;
    time += dt;
    squares += error * error * dt;
    sum += error * dt;
  };
  run(200);
  return {std::sqrt(squares / time), sum / time};
}

/// What a state changes of the torque in a period [s], where the flux is in the direction `angle` and nothing
/// but it flows. [N·m]
double change_by(SwitchState state, double angle, double period) {
  test::ReferenceMachine machine{krause, u_dc};
  machine.psi_s = std::polar(psi_ref, angle);
  machine.psi_r = machine.psi_s * (krause.l_r() / krause.l_m);
  machine.apply(GatePattern{state, std::int32_t(std::lround(period * 1e9))});
  return machine.torque();
}

double step_of(std::int32_t period_ns) {
  return vector_torque(krause, psi_ref, u_dc, period_ns * 1e-9);
}

TEST(VectorTorque, IsWhatAnActiveVectorAcrossTheFluxChangesInAPeriod) {
  for (const std::int32_t period_ns : {10'000, 25'000, 50'000}) {
    const double step = step_of(period_ns);
    EXPECT_NEAR(change_by(switch_states[4], std::numbers::pi / 2, period_ns * 1e-9), step, 0.03 * step);
    EXPECT_NEAR(change_by(switch_states[1], std::numbers::pi / 2, period_ns * 1e-9), -step, 0.03 * step);
  }
}

// The thresholds of the two relays are two bands apart.
TEST(NarrowestTorqueBand, TheLeastStepOfTheTablesVectorsIsFromOneRelaysThresholdToTheOthers) {
  const std::uint32_t seed = 24;
  std::mt19937 dice{seed};
  constexpr std::int32_t period_ns = 25'000;
  const double apart = 2 * narrowest_torque_band(step_of(period_ns));
  SectorSelector<double> sector{{}};
  double least = 1e9;
  double largest = 0;
  for (int k = 0; k < 4000; ++k) {
    const double angle = std::uniform_real_distribution{-std::numbers::pi, std::numbers::pi}(dice);
    sector.step({std::cos(angle), std::sin(angle)});
    for (const int demand : {1, -1}) {
      for (const bool raise_flux : {true, false}) {
        const SwitchState state = select_state(sector.sector(), raise_flux, demand, switch_states[0]);
        const double change = demand * change_by(state, angle, period_ns * 1e-9);
        least = std::min(least, change);
        largest = std::max(largest, change);
      }
    }
  }
  EXPECT_NEAR(least, apart, 0.06 * apart) << "seed " << seed;
  EXPECT_NEAR(largest, 2 * apart, 0.06 * apart) << "seed " << seed;
}

using Dtc = DirectTorqueController<double>;
using Predictive = PredictiveController<double>;

/// torque_band: of both relays. [N·m]
Dtc::Parameters dtc_of(std::int32_t period_ns, int delay, double torque_band) {
  auto p = parameters_of<Dtc>(period_ns, delay);
  p.u_dc = u_dc;
  p.flux_comparator.band = 0.01 * psi_ref;
  p.torque_comparator.upper_band = p.torque_comparator.lower_band = torque_band;
  return p;
}

constexpr double narrow = 0.19;  ///< a quarter percent of the breakdown torque, 76 N·m [N·m]

// Below it the vectors pass the band, and the opposite ones follow.
TEST(NarrowestTorqueBand, LeavesLessRippleThanANarrowerOneAndNoBias) {
  for (const std::int32_t period_ns : {25'000, 125'000}) {
    const double band = narrowest_torque_band(step_of(period_ns));
    ASSERT_GT(band, 2 * narrow);
    for (const double torque : {0.1, -1.0, 1.0}) {
      for (const double omega_m : {0.0, 40.0, -120.0, 170.0}) {
        const int delay = omega_m > 0 ? 1 : 0;
        SCOPED_TRACE(testing::Message() << torque << " at " << omega_m << ", " << period_ns << " ns");
        const Steady wide = steady<Dtc>(dtc_of(period_ns, delay, band), torque * rated, omega_m);
        EXPECT_LT(wide.rms, 0.9 * steady<Dtc>(dtc_of(period_ns, delay, narrow), torque * rated, omega_m).rms);
        EXPECT_LT(std::abs(wide.bias), 0.03 * band);
      }
    }
  }
}

// The relay holds, and no vector makes a torque that is below its band.
TEST(DirectTorqueTrim, AtStandstillATorqueWithinTheBandIsMade) {
  for (const std::int32_t period_ns : {25'000, 50'000, 125'000}) {
    const double band = narrowest_torque_band(step_of(period_ns));
    for (const double share : {0.9, -0.9, 0.4, -0.2}) {
      for (const int delay : {0, 1}) {
        const double torque = share * band;
        SCOPED_TRACE(testing::Message() << torque << ", " << period_ns << " ns, delay " << delay);
        const Steady found = steady<Dtc>(dtc_of(period_ns, delay, band), torque, 0);
        EXPECT_LT(std::abs(found.bias), 0.25 * std::abs(torque));
      }
    }
  }
}

TEST(DefaultTrimTime, IsThatOfThePapersMachineAndGoesWithWhatAVectorMovesOfTheFlux) {
  EXPECT_NEAR(default_trim_time(1.1, 530.0, 25e-6), 0.01, 1e-4);
  for (const double factor : {0.5, 2.0}) {
    const double scaled = 0.01 / factor;
    EXPECT_NEAR(default_trim_time(1.1, 530 * factor, 25e-6), scaled, 0.01 * scaled);
    EXPECT_NEAR(default_trim_time(1.1 / factor, 530.0, 25e-6), scaled, 0.01 * scaled);
    EXPECT_NEAR(default_trim_time(1.1, 530.0, 25e-6 * factor), scaled, 0.01 * scaled);
  }
}

// The trim reaches its value without an oscillation, also with a period of delay.
TEST(DefaultTrimTime, LeavesNoOscillationAtTheLongestPeriods) {
  for (const double period : {250e-6, 400e-6}) {
    const double tau = default_trim_time(psi_ref, u_dc, period);
    EXPECT_GE(tau, 3 * period * (1 - 1e-12));
    TorqueTrim<double> trim{{.time_constant = tau}, krause, period};
    constexpr double offset = -1;  // of the torque from what the method is told
    double told_before = 0;
    double value_before = 0;
    for (int k = 0; k < 200; ++k) {
      const double told = trim.step(0, told_before + offset, psi_ref, u_dc, true);
      told_before = told;
      EXPECT_GE(trim.value(), value_before - 1e-12);
      value_before = trim.value();
    }
    EXPECT_NEAR(trim.value(), -offset, 1e-6);
  }
}

/// Worst mean torque through standstill over torques and speeds. [N·m]
template <class C>
double worst_through_standstill(typename C::Parameters p, double trim_s) {
  p.torque_trim.time_constant = trim_s;
  double worst = 0;
  for (const double torque : {1.0, -0.5, 0.25, -0.25}) {
    for (const double speed : {6.0, 20.0, 60.0}) {
      worst = std::max(worst, worst_mean<C>(p, torque * rated, speed));
    }
  }
  return worst;
}

// With 10 ms, 80 periods of 125 µs, the torque is off its reference for longer than the mean lasts.
TEST(DefaultTrimTime, KeepsTheMeanTorqueOfWholeVectorsThroughStandstill) {
  for (const std::int32_t period_ns : {25'000, 50'000, 125'000}) {
    const double tau = default_trim_time(psi_ref, u_dc, period_ns * 1e-9);
    for (const int delay : {0, 1}) {
      SCOPED_TRACE(testing::Message() << period_ns << " ns, " << delay);
      const auto predictive = parameters_of<Predictive>(period_ns, delay);
      const auto dtc = dtc_of(period_ns, delay, narrowest_torque_band(step_of(period_ns)));
      EXPECT_LT(worst_through_standstill<Predictive>(predictive, tau), 0.5);
      EXPECT_LT(worst_through_standstill<Dtc>(dtc, tau), 0.5);
      if (period_ns < 125'000) continue;
      EXPECT_GT(worst_through_standstill<Predictive>(predictive, 0.01), 1.0);
      EXPECT_GT(worst_through_standstill<Dtc>(dtc, 0.01), 0.5);
    }
  }
}

}  // namespace
}  // namespace sextant
