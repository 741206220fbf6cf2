#include "sextant/safety/current_response.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "sextant/core/switch_state.hpp"
#include "sextant/safety/applied_volt_seconds.hpp"
#include "sextant/safety/current_prediction.hpp"
#include "sextant/safety/monitored_flux.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr unsigned seed = 20240603;

/// Three phases of an inductance with a back-EMF that turns, under random active and zero vectors, and what
/// its sensors read. Its current is the sum of v − e over the periods: an independent integration.
template <class T>
class CurrentResponseOf : public testing::Test {
 protected:
  using Parameters = typename CurrentResponse<T>::Parameters;

  void run(int periods) {
    for (int k = 0; k < periods; ++k) {
      std::uniform_int_distribution<std::size_t> vector{0, 7};
      const ThreePhase<T> applied =
          applied_volt_seconds(GatePattern{switch_states[vector(random)], period_ns}, T(530));
      const double angle = 2e-3 * double(++n);
      const SpaceVector<double> emf = polar(0.6, angle);  // [A] a period
      const ThreePhase<double> e = inverse_clarke(emf);
      const ThreePhase<double> more = along_flux(applied, angle);
      current.a += inductance_share * double(applied.a) / sigma_l_s + more.a - e.a - 0.02 * current.a;
      current.b += inductance_share * double(applied.b) / sigma_l_s + more.b - e.b - 0.02 * current.b;
      current.c += inductance_share * double(applied.c) / sigma_l_s + more.c - e.c - 0.02 * current.c;
      largest_jump = std::max(largest_jump, double(response.jump()));
      std::normal_distribution<double> noise{0.0, sigma};
      ThreePhase<T> read{T(current.a + noise(random)), T(current.b + noise(random)),
                         T(current.c + noise(random))};
      if (tamper) tamper(read);
      response.step(read, predicted(applied), T(1));
    }
  }
  /// By the voltage alone: the test's back-EMF changes little from period to period.
  [[nodiscard]] static PredictedChange<T> predicted(const ThreePhase<T>& applied) {
    return {.v = {T(double(applied.a) / sigma_l_s), T(double(applied.b) / sigma_l_s),
                  T(double(applied.c) / sigma_l_s)}};
  }
  /// What a flux that saturates, at an angle, adds to the change of the currents. [A]
  [[nodiscard]] ThreePhase<double> along_flux(const ThreePhase<T>& applied, double angle) const {
    const SpaceVector<double> axis = polar(1.0, angle);
    const SpaceVector<double> v =
        clarke(ThreePhase<double>{double(applied.a), double(applied.b), double(applied.c)});
    return inverse_clarke((saturated_share * dot(v, axis) / sigma_l_s) * axis);
  }
  [[nodiscard]] double of(std::size_t phase) const {
    return double(response.phase(phase).answered) / double(response.phase(phase).expected);
  }

  static constexpr double sigma_l_s = 0.004735;
  std::mt19937 random{seed};
  double sigma{0.2};
  double inductance_share{1.0};  ///< of the current's change against that of σL_s
  double saturated_share{0.0};   ///< by which a change along the flux exceeds that of σL_s
  double largest_jump{0.0};      ///< of all periods [A]
  ThreePhase<double> current{};
  long n{0};
  std::function<void(ThreePhase<T>&)> tamper{};
  CurrentResponse<T> response{Parameters{.period_ns = period_ns}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CurrentResponseOf, Scalars);

TYPED_TEST(CurrentResponseOf, OfAWorkingSensorIsTheRatioOfTheInductances) {
  SCOPED_TRACE(seed);
  for (const double share : {0.7, 1.0, 1.4}) {
    this->inductance_share = share;
    this->run(2000);
    for (const std::size_t phase : {0U, 1U, 2U}) EXPECT_NEAR(this->of(phase), share, 0.07);
    EXPECT_LT(this->response.jump(), 4.0);
  }
}

TYPED_TEST(CurrentResponseOf, OfASensorThatIsStuckFallsToZeroWithTheWindow) {
  using T = TypeParam;
  this->run(1000);
  this->tamper = [](ThreePhase<T>& i) { i.b = T(7); };
  this->run(120);  // a time constant of the window
  EXPECT_NEAR(this->of(1), std::exp(-1.0), 0.1);
  this->run(1000);
  EXPECT_NEAR(this->of(1), 0.0, 0.01);
  EXPECT_NEAR(this->of(0), 1.0, 0.07);
  EXPECT_TRUE(this->response.phase(1).counts(T(60)) && this->response.phase(1).is_below(T(0.35)));
  EXPECT_FALSE(this->response.phase(0).counts(T(60)) && this->response.phase(0).is_below(T(0.35)));
}

TYPED_TEST(CurrentResponseOf, OfTwoSwappedSensorsIsMinusOneHalf) {
  using T = TypeParam;
  this->sigma = 1e-3;
  this->tamper = [](ThreePhase<T>& i) { std::swap(i.a, i.c); };
  this->run(2000);
  EXPECT_NEAR(this->of(0), -0.5, 0.15);
  EXPECT_NEAR(this->of(2), -0.5, 0.15);
  EXPECT_NEAR(this->of(1), 1.0, 0.07);
}

TYPED_TEST(CurrentResponseOf, WithoutExpectationThereIsNoVerdict) {
  using T = TypeParam;
  this->response.restart({T(5), T(-2), T(-3)});
  for (int k = 0; k < 1000; ++k) this->response.step({T(5), T(-2), T(-3)}, {}, T(1));
  for (const std::size_t phase : {0U, 1U, 2U}) {
    EXPECT_FALSE(this->response.phase(phase).counts(T(60)) && this->response.phase(phase).is_below(T(0.35)));
  }
  EXPECT_EQ(this->response.hidden_change(), T(0)) << "a zero vector at zero flux moves no current";
}

TYPED_TEST(CurrentResponseOf, AJumpIsReportedInItsPeriodAndIsNoResponse) {
  using T = TypeParam;
  this->run(1000);
  const double before = this->of(0);
  this->tamper = [](ThreePhase<T>& i) { i.a += T(20); };
  this->run(1);
  EXPECT_NEAR(double(this->response.jump()), 20.0, 3.0);
  EXPECT_NEAR(this->of(0), before, 0.1);
  this->run(1);
  EXPECT_NEAR(double(this->response.jump()), 20.0, 3.0) << "the second difference has it twice";
  this->run(1);
  EXPECT_LT(this->response.jump(), 4.0);
}

// The incremental inductance along a saturated flux is a small part of L_m, which shunts the leakage: the
// transient inductance falls to half. |w| of these vectors reaches 2 · 1.87 A.
TYPED_TEST(CurrentResponseOf, AVoltageThatActsTwiceAlongASaturatedFluxIsNoJump) {
  SCOPED_TRACE(seed);
  this->sigma = 1e-6;
  this->saturated_share = 1.0;
  this->run(4000);
  EXPECT_LT(this->largest_jump, 0.2);
  this->saturated_share = 2.0;
  this->run(4000);
  EXPECT_GT(this->largest_jump, 2.0) << "a third of σL_s explains more than is allowed for";
}

// Under 530 V an active vector moves phase a by 2/3 · 530 V · 25 µs / 4.735 mH = 1.8656 A, the others by
// half.
TYPED_TEST(CurrentResponseOf, ReadingsThatStandStillHideTheChangeByTheVoltage) {
  using T = TypeParam;
  const PredictedChange<T> active =
      this->predicted(applied_volt_seconds(GatePattern{switch_states[1], period_ns}, T(530)));
  const ThreePhase<T> read{T(5), T(-2), T(-3)};
  this->response.restart({T(5), T(-2.5), T(-2.5)});
  this->response.step(read, {}, T(1));
  EXPECT_EQ(this->response.hidden_change(), T(0)) << "a reading has changed";
  this->response.restart(read);
  for (int k = 1; k <= 5; ++k) {
    this->response.step(read, active, T(1));
    EXPECT_NEAR(double(this->response.hidden_change()), 1.8656 * k, 1e-3);
    this->response.step(read, {}, T(1));
    EXPECT_NEAR(double(this->response.hidden_change()), 1.8656 * k, 1e-3) << "a zero vector adds nothing";
  }
  this->response.step({T(5), T(-2.5), T(-2.5)}, active, T(1));
  EXPECT_EQ(this->response.hidden_change(), T(0));
}

/// A current that rises as at the first magnetising, then stays: by a model whose inductance is a tenth too
/// small it ought to have risen by a tenth more, and the steady current has no such error.
TYPED_TEST(CurrentResponseOf, AnErrorOfTheInductanceInARiseIsNoneOfTheSteadyCurrent) {
  using T = TypeParam;
  CurrentResponse<T> judged{typename TestFixture::Parameters{.period_ns = period_ns, .step = T(0.02)}};
  const auto along_a = [](T x) { return ThreePhase<T>{x, T(-0.5) * x, T(-0.5) * x}; };
  judged.restart(along_a(T(0)));
  T rising = T(0);
  for (int k = 0; k < 20; ++k) {
    rising += T(1);
    judged.step(along_a(rising), {.v = along_a(T(1.1)), .uncertainty = T(0.05)}, T(1));
  }
  for (int k = 0; k < 60; ++k) {
    judged.step(along_a(rising), {.v = along_a(T(0)), .uncertainty = T(0.05)}, T(1));
    ASSERT_EQ(judged.hidden_change(), T(0)) << k;
  }
}

TYPED_TEST(CurrentResponseOf, ReadingsThatStandStillHideTheChangeByTheBackEmf) {
  using T = TypeParam;
  ThreePhase<T> i{};
  const PredictedChange<T> emf{.e = {T(0.5), T(-0.25), T(-0.25)}, .uncertainty = T(0.1)};
  this->response.restart(i);
  for (int k = 0; k < 100; ++k) {  // under a zero vector the back-EMF alone moves the currents
    i = {i.a - T(0.5), i.b + T(0.25), i.c + T(0.25)};
    this->response.step(i, emf, T(1));
    EXPECT_EQ(this->response.hidden_change(), T(0));
  }
  for (int k = 1; k <= 8; ++k) {
    this->response.step(i, emf, T(1));
    EXPECT_NEAR(double(this->response.hidden_change()), 0.5 * k - 0.25 * 0.1 * k, 1e-4)
        << "but for its uncertainty";
  }
}

// A converter's step of 0.2 A: readings that toggle by it stand still, and may hide one step.
TYPED_TEST(CurrentResponseOf, ReadingsWithinOneStepOfTheConverterAreEqual) {
  using T = TypeParam;
  for (const double width : {0.19, 0.21}) {
    CurrentResponse<T> quantised{{.period_ns = period_ns, .step = T(0.2)}};
    const ThreePhase<T> low{T(4), T(-2), T(-2)};
    const ThreePhase<T> high{T(4 + width), T(-2), T(-2 - width)};
    quantised.restart(low);
    for (int k = 1; k <= 20; ++k) {
      quantised.step(k % 2 == 1 ? high : low, {.v = {T(0.5), T(-0.25), T(-0.25)}}, T(1));
      EXPECT_NEAR(double(quantised.hidden_change()), width < 0.2 ? (0.5 - 0.25 * 0.2) * k - 0.2 : 0.0, 1e-4)
          << width;
    }
  }
}

// A direct current under noise: its readings stand still for tens of periods. That it moves by a sixteenth of
// a step a period, of which the model knows half, is learnt over all of them, not from the reading that ends
// them.
TYPED_TEST(CurrentResponseOf, NoiseOfADirectCurrentIsNoErrorOfTheModel) {
  using T = TypeParam;
  std::mt19937 dice{seed};
  for (const double deviation : {0.1, 0.27, 0.5}) {  // steps
    std::normal_distribution<double> noise{0.0, deviation};
    CurrentResponse<T> judged{{.period_ns = period_ns, .jump = T(100), .step = T(1)}};
    double largest = 0.0;
    for (int k = 0; k < 100'000; ++k) {
      const double i = (k % 2000 < 1000 ? k % 1000 : 1000 - k % 1000) / 16.0;
      const double change = k % 2000 < 1000 ? 1.0 / 32.0 : -1.0 / 32.0;
      judged.step({T(i + noise(dice)), T(-0.5 * i + noise(dice)), T(-0.5 * i + noise(dice))},
                  {.v = {T(change), T(-0.5 * change), T(-0.5 * change)}}, T(1));
      largest = std::max(largest, double(judged.hidden_change()));
    }
    EXPECT_LT(largest, 1.0) << "steps, deviation " << deviation << ", seed " << seed;
  }
}

// Of a smooth voltage that turns with a back-EMF of 30 A a period, at 12 to 100 periods a turn: what the
// voltage has beside the back-EMF moves the current. A model that is wrong by 30 % in any direction is not
// judged by; a current that does not answer to as much as the back-EMF has is.
TYPED_TEST(CurrentResponseOf, ASmoothVoltageIsJudgedByWhatExceedsTheErrorOfTheModel) {
  using T = TypeParam;
  for (const int periods_a_turn : {12, 20, 40, 100}) {
    for (const double direction : {0.0, 1.5, 3.1, 4.7}) {
      const auto is_unresponsive = [&](double share, double drive) {
        CurrentResponse<T> judged{{.period_ns = period_ns, .jump = T(50)}};
        SpaceVector<double> i{};
        bool any = false;
        for (int k = 0; k < 1000; ++k) {
          const double angle = 6.283185307 * k / periods_a_turn;
          const ThreePhase<double> raised = inverse_clarke(polar(drive, angle));
          const ThreePhase<double> e = inverse_clarke(polar(30.0, angle) + polar(9.0, angle + direction));
          const ThreePhase<double> v = inverse_clarke(polar(30.0, angle) + polar(drive, angle));
          i.alpha += share * clarke(raised).alpha;
          i.beta += share * clarke(raised).beta;
          const ThreePhase<double> read = inverse_clarke(i);
          judged.step({T(read.a), T(read.b), T(read.c)},
                      {.v = {T(v.a), T(v.b), T(v.c)}, .e = {T(e.a), T(e.b), T(e.c)}, .uncertainty = T(9.5)},
                      T(1));
          for (const std::size_t phase : {0U, 1U, 2U})
            any = any || judged.is_unresponsive(phase, T(0.35), T(0.04));
        }
        return any;
      };
      EXPECT_FALSE(is_unresponsive(1.0, 1.0)) << periods_a_turn << ", " << direction;
      EXPECT_FALSE(is_unresponsive(1.0, 30.0)) << periods_a_turn << ", " << direction;
      EXPECT_TRUE(is_unresponsive(0.0, 30.0)) << periods_a_turn << ", " << direction;
    }
  }
}

/// A machine without torque whose flux is weakened at a speed, so that its iron does not saturate: from rotor
/// flux and its own L_m follow current and voltage in closed form. The model that judges it has the L_m of
/// the saturated machine, half of that. The sensors of two phases have gains and offsets of opposite sign,
/// all have noise and a converter's step.
template <class T>
class WeakenedMachine {
 public:
  static constexpr double step = 0.75;  ///< within which readings are equal, with their noise [A]

  WeakenedMachine(double omega_m, std::int32_t with_period_ns, unsigned with_seed)
      : omega_{2.0 * omega_m},
        dt_{with_period_ns * 1e-9},
        flux_{300.0 / std::abs(omega_)},
        random_{with_seed},
        prediction_{InductionMachineParameters<T>{}, {.voltage_error = T(4)}, with_period_ns},
        monitored_{InductionMachineParameters<T>{}},
        judged_{{.period_ns = with_period_ns, .jump = T(100), .step = T(step)}} {
    true_machine_.l_m *= 2.0;
  }

  /// A period; raise: what the voltage changes the current by, beside what keeps it turning [A]. With
  /// `frozen` the converter stands still.
  void run(double raise = 0.0, bool frozen = false) {
    const double before = angle_;
    angle_ += omega_ * dt_;
    const SpaceVector<double> i_before = current(before);
    const SpaceVector<double> i_s = current(angle_);
    const double sigma_l_s = InductionMachineParameters<double>{}.sigma_l_s();
    const SpaceVector<double> volt_seconds =
        true_machine_.k_r() * (polar(flux_, angle_) - polar(flux_, before)) + sigma_l_s * (i_s - i_before) +
        (0.5 * dt_ * true_machine_.r_s) * (i_before + i_s) + sigma_l_s * polar(raise, angle_);
    if (!frozen) read_ = reading(inverse_clarke(i_s));
    const SpaceVector<T> read = clarke(read_);
    monitored_.step(T(0.5) * (read + last_), T(0.5 * omega_), T(dt_));
    last_ = read;
    const ThreePhase<double> v = inverse_clarke(volt_seconds);
    judged_.step(read_,
                 prediction_.step(read_, {monitored_.psi_r(), T(0), T(omega_ * dt_)},
                                  {T(v.a), T(v.b), T(v.c)}, T(530), T(dt_)),
                 T(1));
  }
  [[nodiscard]] double hidden() const { return double(judged_.hidden_change()); }

 private:
  [[nodiscard]] SpaceVector<double> current(double at) const { return polar(flux_ / true_machine_.l_m, at); }
  ThreePhase<T> reading(const ThreePhase<double>& i) {
    std::normal_distribution<double> noise{0.0, 0.2};
    const auto converted = [&](double x) {
      constexpr double bit = 600.0 / 4096.0;
      return T(bit * std::round((x + noise(random_)) / bit));
    };
    return {converted(1.02 * i.a + 0.5), converted(0.98 * i.b - 0.5), converted(i.c)};
  }

  InductionMachineParameters<double> true_machine_{};
  double omega_;  ///< electrical [rad/s]
  double dt_;     ///< [s]
  double flux_;   ///< of the rotor, at a link of some 530 V [Wb]
  std::mt19937 random_;
  CurrentPrediction<T> prediction_;
  MonitoredFlux<T> monitored_;
  CurrentResponse<T> judged_;
  ThreePhase<T> read_{};
  SpaceVector<T> last_{};
  double angle_{};  ///< of the rotor flux [rad]
};

// The small current of the unsaturated machine stands still within the noise for some periods, while the
// model lacks half of its back-EMF, 3 A a period at 125 us. That half turns with the machine.
TYPED_TEST(CurrentResponseOf, ABackEmfOfTwiceTheModelIsNoHiddenChangeOfASmallCurrent) {
  using T = TypeParam;
  const unsigned own_seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << own_seed);
  for (const std::int32_t period : {25'000, 125'000, 250'000}) {
    for (const double omega_m : {-400.0, -300.0, 200.0, 300.0, 400.0}) {
      WeakenedMachine<T> machine{omega_m, period, own_seed};
      const long settled = std::lround(0.5e9 / period);
      double largest = 0.0;
      for (long k = 0; k < 4 * settled; ++k) {
        machine.run();
        if (k > settled) largest = std::max(largest, machine.hidden());
      }
      EXPECT_LT(largest, 2.0) << omega_m << " rad/s, " << period << " ns";
    }
  }
}

// The voltage of a controller that reads a current of a converter that has stopped raises it by 6 A a period.
TYPED_TEST(CurrentResponseOf, AConverterThatStopsAtWeakenedFluxHidesWhatTheVoltageRaises) {
  using T = TypeParam;
  const unsigned own_seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << own_seed);
  for (const double omega_m : {-400.0, 300.0}) {
    for (int more = 0; more < 60; more += 7) {
      WeakenedMachine<T> machine{omega_m, 125'000, own_seed};
      for (int k = 0; k < 4'000 + more; ++k) machine.run();
      int periods = 0;
      while (periods < 40 && machine.hidden() < 6.0) {
        machine.run(6.0, true);
        ++periods;
      }
      EXPECT_LE(periods, 8) << omega_m << " rad/s, after " << more;
    }
  }
}

TYPED_TEST(CurrentResponseOf, ARestartForgets) {
  using T = TypeParam;
  this->run(100);
  this->response.restart({});
  for (const std::size_t phase : {0U, 1U, 2U}) EXPECT_EQ(this->response.phase(phase).expected, T(0));
  this->response.step({T(100), T(-50), T(-50)}, {}, T(1));
  EXPECT_EQ(this->response.jump(), T(0)) << "the first period has nothing to differ from";
}

}  // namespace
}  // namespace sextant
