#include "sextant/safety/phase_continuity.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "safety/steady_machine.hpp"
#include "sextant/safety/applied_volt_seconds.hpp"
#include "sextant/safety/current_response.hpp"

namespace sextant {
namespace {

constexpr double z = 2.0;  // reading of no current [A]

template <class T>
class PhaseContinuityOf : public testing::Test {
 protected:
  /// A period in which phase a reads i_a and ought to change by `predicted`, the others carry `peak`. [A]
  void step(double i_a, double peak, double predicted, double uncertainty = 0.0, double turn = 0.0) {
    const ThreePhase<T> v{T(predicted), T(-0.5 * predicted), T(-0.5 * predicted)};
    continuity.step({T(i_a), T(peak), T(-peak)}, {.v = v, .uncertainty = T(uncertainty), .turn = T(turn)});
  }
  PhaseContinuity<T> continuity{{.zero_current = T(z), .response = T(1)}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PhaseContinuityOf, Scalars);

TYPED_TEST(PhaseContinuityOf, VoltageThatRaisesNoCurrentForTwentyPeriodsIsAnOpenPhase) {
  for (const double sign : {-1.0, 1.0}) {
    this->continuity.restart();
    for (int k = 1; k <= 19; ++k) {
      this->step(0.0, 10.0, sign);
      EXPECT_FALSE(this->continuity.is_open(0)) << k;
    }
    this->step(0.0, 10.0, sign);
    EXPECT_TRUE(this->continuity.is_open(0));
    EXPECT_FALSE(this->continuity.is_open(1)) << "carries current";
    EXPECT_FALSE(this->continuity.is_open(2));
    this->step(2.1, 10.0, sign);
    EXPECT_FALSE(this->continuity.is_open(0)) << "carries current now";
  }
}

TYPED_TEST(PhaseContinuityOf, ACurrentThatStaysNearZeroIsNone) {
  for (int k = 0; k < 2000; ++k) {  // from −2 to 2 A and back
    const double before = 1.99 * std::cos(0.01 * k);
    const double i = 1.99 * std::cos(0.01 * (k + 1));
    this->step(i, 10.0, k == 0 ? 50.0 : i - before);
    ASSERT_FALSE(this->continuity.is_open(0)) << "the change that led to zero does not count";
  }
}

TYPED_TEST(PhaseContinuityOf, APhaseThatAnswersByHalfMayBePredictedToChangeByTwiceAsMuch) {
  using T = TypeParam;
  for (const double predicted : {7.9, 8.1}) {
    this->continuity = PhaseContinuity<T>{{.zero_current = T(z), .response = T(0.5)}};
    for (int k = 0; k <= 20; ++k) this->step(0.0, 10.0, k == 1 ? predicted : 0.0);
    EXPECT_EQ(this->continuity.is_open(0), predicted > 8.0);
    this->continuity = PhaseContinuity<T>{{.zero_current = T(z), .response = T(0)}};
    for (int k = 0; k < 1000; ++k) this->step(0.0, 10.0, predicted);
    EXPECT_FALSE(this->continuity.is_open(0)) << "switched off";
  }
}

TYPED_TEST(PhaseContinuityOf, TheUncertaintyOfThePredictionIsAllowedForUntilTheFluxHasTurned) {
  // Of a peak of 20 A a healthy phase is below 2 A for 0.2 rad; allowed are 0.35 + 8 · 0.1 rad.
  for (const double turn : {0.0, 0.01, -0.01}) {
    this->continuity.restart();
    int open_at = 0;
    for (int k = 1; k <= 400 && open_at == 0; ++k) {
      this->step(0.0, 20.0, 0.3, 0.4, turn);
      if (this->continuity.is_open(0)) open_at = k;
    }
    EXPECT_NEAR(open_at, turn == 0.0 ? 0 : 117, 1);
  }
}

TYPED_TEST(PhaseContinuityOf, NoTurnCountsWhileTheOthersCarryLittle) {
  for (int k = 0; k < 1000; ++k) this->step(0.0, 7.9, 0.3, 0.4, 0.05);
  EXPECT_FALSE(this->continuity.is_open(0));
  for (int k = 0; k < 30; ++k) this->step(0.0, 20.0, 0.3, 0.4, 0.05);
  EXPECT_TRUE(this->continuity.is_open(0));
}

// By a model whose EMF is wrong a current that passes through zero ought to change by ten times as much as it
// does: it moves, an open phase does not.
TYPED_TEST(PhaseContinuityOf, ACurrentThatPassesThroughZeroIsNoOpenPhase) {
  for (int k = 0; k <= 160; ++k) {
    this->step(-2.0 + k * 0.025, 10.0, 0.08);
    EXPECT_FALSE(this->continuity.is_open(0)) << k;
  }
  this->continuity.restart();
  for (int k = 0; k <= 160; ++k) this->step(0.5, 10.0, 0.08);
  EXPECT_TRUE(this->continuity.is_open(0)) << "readings that stand still";
}

/// A machine without torque at weakened flux, by its phasors, judged by a model whose L_m is a share of its
/// own.
template <class T>
class MisjudgedMachine {
 public:
  MisjudgedMachine(double omega_m, double share)
      : share_{share}, psi_r_{300.0 / (2.0 * std::abs(omega_m))}, steady_{machine(), psi_r_, omega_m, 0.0} {
    InductionMachineParameters<T> believed{};
    believed.l_m = T(share * machine().l_m);
    prediction_ = CurrentPrediction<T>{believed, T(0)};
  }

  /// A period; with `raised` [A] phase a is open, and the voltage along it is raised by so much in vain.
  void run(double raised = 0.0) {
    const double dt = SteadyMachine::dt;
    const Measurement<T> m = steady_.template measurement<T>(++n_);
    const SpaceVector<double> psi = share_ * steady_.psi_r(double(n_) * dt);  // L_m i of the model
    ThreePhase<T> i = m.i_abc;
    if (raised != 0.0) i.a = T(0);
    PredictedChange<T> change =
        prediction_.step(i, {{T(psi.alpha), T(psi.beta)}, T(0), T(steady_.omega_e() * dt)},
                         applied_volt_seconds(m.applied, m.u_dc), m.u_dc, T(dt));
    change.v.a += T(raised);
    response_.step(i, change, T(1));
    continuity_.step(i, change, response_.error());
  }
  [[nodiscard]] double i_a() const {
    return double(inverse_clarke(steady_.i_s(double(n_) * SteadyMachine::dt)).a);
  }
  [[nodiscard]] bool is_open() const {
    return continuity_.is_open(0) || continuity_.is_open(1) || continuity_.is_open(2);
  }

 private:
  static InductionMachineParameters<double> machine() {
    InductionMachineParameters<double> m{};
    m.l_m *= 2.0;
    return m;
  }

  double share_;  ///< [-]
  double psi_r_;  ///< [Wb]
  SteadyMachine steady_;
  CurrentPrediction<T> prediction_{InductionMachineParameters<T>{}, T(0)};
  CurrentResponse<T> response_{{.step = T(0.75)}};
  PhaseContinuity<T> continuity_{{.zero_current = T(2.5), .noise = T(2.25)}};
  std::int64_t n_{0};
};

// The model of 0.35 L_m has a third of the back-EMF: 1.6 A a period at 400 rad/s, of which it misses 1.1 A.
TYPED_TEST(PhaseContinuityOf, AnInductanceThatIsAnotherAtWeakenedFluxOpensNoPhase) {
  for (const double omega_m : {-400.0, -200.0, 150.0, 200.0, 300.0}) {
    for (const double share : {0.35, 0.5, 1.0}) {
      MisjudgedMachine<TypeParam> machine{omega_m, share};
      bool any = false;
      for (int k = 0; k < 20'000; ++k) {
        machine.run();
        any = any || (k > 1000 && machine.is_open());
      }
      EXPECT_FALSE(any) << omega_m << " rad/s, " << share;
    }
  }
}

// Voltage for 3 A a period is raised in vain, from the zero of the current on.
TYPED_TEST(PhaseContinuityOf, AnOpenPhaseIsFoundAlsoByAWrongInductance) {
  for (const double omega_m : {-300.0, 200.0}) {
    for (const double share : {0.35, 0.5, 1.0}) {
      for (const double sign : {-1.0, 1.0}) {
        MisjudgedMachine<TypeParam> machine{omega_m, share};
        for (int k = 0; k < 1000 || std::abs(machine.i_a()) > 0.2; ++k) machine.run();
        int periods = 0;
        while (periods < 100 && !machine.is_open()) {
          machine.run(3.0 * sign);
          ++periods;
        }
        EXPECT_LE(periods, 60) << omega_m << " rad/s, " << share << ", " << sign;
      }
    }
  }
}

}  // namespace
}  // namespace sextant
