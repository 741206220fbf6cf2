#include "sextant/safety/protection.hpp"

#include <cstddef>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "safety/joined_reads.hpp"
#include "safety/steady_machine.hpp"

namespace sextant {
namespace {

template <class T>
class ProtectionOf : public testing::Test {
 protected:
  static constexpr T nan = std::numeric_limits<T>::quiet_NaN();
  static constexpr T infinity = std::numeric_limits<T>::infinity();

  [[nodiscard]] static Measurement<T> healthy() {
    Measurement<T> m;
    m.i_abc = {T(50), T(-20), T(-30)};
    m.u_dc = T(530);
    m.omega_m = T(100);
    return m;
  }
  [[nodiscard]] static FaultSet only(Fault f) {
    FaultSet set;
    set.set(f);
    return set;
  }
  /// As of a period with an active vector.
  [[nodiscard]] static GatePattern driven() { return {switch_states[1], 25'000}; }
  /// A current that does not stand still.
  static void change_current(Measurement<T>& m) {
    m.i_abc.a += T(0.5);
    m.i_abc.b -= T(0.5);
  }
  void restart() { protection = Protection<T>{parameters}; }

  static constexpr typename Protection<T>::Parameters parameters{
      .over_current = T(200), .dc_over_voltage = T(700), .over_speed = T(160)};
  Protection<T> protection{parameters};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(ProtectionOf, Scalars);

TYPED_TEST(ProtectionOf, AHealthyMeasurementShowsNoFault) {
  EXPECT_TRUE(this->protection.is_usable(this->healthy()));
  EXPECT_FALSE(this->protection.step(this->healthy()).any());
}

TYPED_TEST(ProtectionOf, OverCurrentIsSeenInEachPhaseAndSign) {
  using T = TypeParam;
  for (const auto phase : {&ThreePhase<T>::a, &ThreePhase<T>::b, &ThreePhase<T>::c}) {
    for (const T sign : {T(-1), T(1)}) {
      Measurement<T> m = this->healthy();
      const auto set = [&](T current) {  // without a sum
        m.i_abc = {-current / T(2), -current / T(2), -current / T(2)};
        m.i_abc.*phase = current;
      };
      set(sign * T(200));
      EXPECT_FALSE(this->protection.step(m).any());
      set(sign * T(200.1));
      EXPECT_EQ(this->protection.step(m), this->only(Fault::over_current));
    }
  }
}

TYPED_TEST(ProtectionOf, OverVoltageIsSeenAboveItsLevel) {
  using T = TypeParam;
  Measurement<T> m = this->healthy();
  m.u_dc = T(700);
  EXPECT_FALSE(this->protection.step(m).any());
  m.u_dc = T(700.1);
  EXPECT_EQ(this->protection.step(m), this->only(Fault::dc_over_voltage));
}

TYPED_TEST(ProtectionOf, OverSpeedIsSeenBothWays) {
  using T = TypeParam;
  for (const T sign : {T(-1), T(1)}) {
    Measurement<T> m = this->healthy();
    m.omega_m = sign * T(160);
    EXPECT_FALSE(this->protection.step(m).any());
    m.omega_m = sign * T(160.1);
    EXPECT_EQ(this->protection.step(m), this->only(Fault::over_speed));
  }
}

TYPED_TEST(ProtectionOf, EveryNumberMustBeFinite) {
  using T = TypeParam;
  for (const T bad : {this->nan, this->infinity, -this->infinity}) {
    for (int which = 0; which < 7; ++which) {
      Measurement<T> m = this->healthy();
      m.theta_m = T(1);
      m.winding_temperature = T(40);
      EXPECT_FALSE(this->protection.step(m).any());
      T* const numbers[] = {
          &m.i_abc.a, &m.i_abc.b, &m.i_abc.c, &m.u_dc, &m.omega_m, &*m.theta_m, &*m.winding_temperature};
      *numbers[which] = bad;
      EXPECT_FALSE(this->protection.is_usable(m));
      EXPECT_EQ(this->protection.step(m), this->only(Fault::measurement_invalid)) << which;
    }
  }
}

// A converter's rail, a broken word on a link: no sensor reads that.
TYPED_TEST(ProtectionOf, ANumberBeyondTheRangeOfItsSensorIsNoMeasurement) {
  using T = TypeParam;
  const ProtectionLimits<T> limits{};
  for (const T sign : {T(-1), T(1)}) {
    for (int which = 0; which < 5; ++which) {
      const T range = which < 3    ? limits.current_range
                      : which == 3 ? limits.voltage_range
                                   : limits.speed_range;
      for (const bool beyond : {false, true}) {
        Measurement<T> m = this->healthy();
        T* const numbers[] = {&m.i_abc.a, &m.i_abc.b, &m.i_abc.c, &m.u_dc, &m.omega_m};
        *numbers[which] = sign * range * (beyond ? T(1.001) : T(0.999));
        EXPECT_EQ(this->protection.is_usable(m), !beyond) << which;
      }
    }
  }
}

// A shorted or open sensor would take the place of the model, and no winding would ever be hot.
TYPED_TEST(ProtectionOf, ATemperatureThatNoWindingHasIsNoMeasurement) {
  using T = TypeParam;
  for (const T celsius : {T(-200), T(-61), T(301), T(850)}) {
    Measurement<T> m = this->healthy();
    m.winding_temperature = celsius;
    EXPECT_EQ(this->protection.step(m), this->only(Fault::measurement_invalid)) << celsius;
  }
  for (const T celsius : {T(-59), T(0), T(140)}) {
    Measurement<T> m = this->healthy();
    m.winding_temperature = celsius;
    EXPECT_TRUE(this->protection.is_usable(m)) << celsius;
  }
}

// It would count as hot for hours.
TYPED_TEST(ProtectionOf, AReadingBeyondTheTripLevelDoesNotHeatTheModelOfTheWindingFurther) {
  using T = TypeParam;
  typename Protection<T>::Parameters p;
  p.winding.nominal_current = T(40);
  Protection<T> heated{p};
  Measurement<T> m = this->healthy();
  m.i_abc = {T(1900), T(-950), T(-950)};
  for (int k = 0; k < 16'000; ++k) (void)heated.step(m);  // 0.4 s
  EXPECT_EQ(heated.available_share(), T(1));
}

TYPED_TEST(ProtectionOf, AnUnansweredReadIsAFault) {
  Measurement<TypeParam> m = this->healthy();
  m.plausible = false;
  EXPECT_EQ(this->protection.step(m), this->only(Fault::measurement_invalid));
}

TYPED_TEST(ProtectionOf, UnderVoltageIsSeenBelowItsLevelWithTheGatesDriven) {
  using T = TypeParam;
  Measurement<T> m = this->healthy();
  m.u_dc = T(264);
  EXPECT_FALSE(this->protection.step(m).any()) << "a link that is not charged yet";
  m.applied = this->driven();
  EXPECT_EQ(this->protection.step(m), this->only(Fault::dc_under_voltage));
  m.u_dc = T(265);
  EXPECT_FALSE(this->protection.step(m).any());
}

TYPED_TEST(ProtectionOf, CurrentsThatDoNotAddUpToZeroAreAFaultInTheThirdPeriod) {
  using T = TypeParam;
  for (const T sign : {T(-1), T(1)}) {
    Measurement<T> m = this->healthy();
    // 6 A, and 5 % of the largest of the currents.
    m.i_abc = {sign * T(50), sign * T(-20), sign * T(-21.6)};
    for (int k = 0; k < 100; ++k) EXPECT_FALSE(this->protection.step(m).any()) << "just inside";
    m.i_abc.c = sign * T(-21.4);
    EXPECT_FALSE(this->protection.step(m).any());
    EXPECT_FALSE(this->protection.step(m).any());
    EXPECT_EQ(this->protection.step(m), this->only(Fault::current_sum));
    EXPECT_EQ(this->protection.step(m), this->only(Fault::current_sum)) << "as long as it lasts";
    EXPECT_FALSE(this->protection.step(this->healthy()).any());
  }
}

TYPED_TEST(ProtectionOf, ASumThatNoiseTakesBelowItsLimitNowAndThenIsAFaultAllTheSame) {
  Measurement<TypeParam> m = this->healthy();
  const auto step = [&](bool violates) {
    m.i_abc.c = TypeParam(violates ? -21 : -30);
    return this->protection.step(m).any();
  };
  for (const bool violates : {true, true, false, true}) EXPECT_FALSE(step(violates));
  EXPECT_TRUE(step(true)) << "three more than not";
  EXPECT_FALSE(step(false));
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(step(k % 2 == 1)) << "no more than not";
}

TYPED_TEST(ProtectionOf, AnUnusableMeasurementBreaksARow) {
  using T = TypeParam;
  Measurement<T> m = this->healthy();
  m.i_abc.c = T(0);
  EXPECT_FALSE(this->protection.step(m).any());
  EXPECT_FALSE(this->protection.step(m).any());
  Measurement<T> none = m;
  none.plausible = false;
  EXPECT_EQ(this->protection.step(none), this->only(Fault::measurement_invalid));
  EXPECT_FALSE(this->protection.step(m).any());
}

/// Measurements of a load of σL_s, of which phase a answers the voltage with a share of what it ought to.
template <class T>
class AnsweringLoad {
 public:
  /// The next measurement under random vectors; `offset` is that of the sensor of phase a. [A]
  Measurement<T> next(double share, double offset) {
    const SwitchState state = switch_states[vector_(random_)];
    const GatePattern applied{state, 25'000};
    const ThreePhase<T> v = applied_volt_seconds(applied, T(530));
    i_.a += share * double(v.a) / sigma_l_s - 0.02 * i_.a;
    i_.b += double(v.b) / sigma_l_s - 0.02 * i_.b;
    i_.c = -i_.a - i_.b;
    Measurement<T> m;
    m.i_abc = {T(i_.a + offset), T(i_.b), T(i_.c)};
    m.u_dc = T(530);
    m.applied = applied;
    return m;
  }

 private:
  static constexpr double sigma_l_s = InductionMachineParameters<double>{}.sigma_l_s();
  ThreePhase<double> i_{};
  std::mt19937 random_{20240703};
  std::uniform_int_distribution<std::size_t> vector_{0, 7};
};

TYPED_TEST(ProtectionOf, APhaseThatNeitherAnswersNorCarriesCurrentIsOpenAndOneWithAReadingIsASensor) {
  using T = TypeParam;
  const auto run = [this](double share, double offset) {
    this->protection = Protection<T>{typename Protection<T>::Parameters{}};
    AnsweringLoad<T> load;
    FaultSet faults;
    for (int k = 0; k < 800; ++k) faults |= this->protection.step(load.next(share, offset));
    return faults;
  };
  EXPECT_FALSE(run(1.0, 0.0).any());
  EXPECT_FALSE(run(0.45, 0.0).any()) << "just inside the smallest response of 0.35";
  EXPECT_EQ(run(0.0, 0.0), this->only(Fault::open_phase));
  EXPECT_EQ(run(0.0, 1.9), this->only(Fault::open_phase)) << "the reading is still that of no current";
  EXPECT_EQ(run(0.0, 2.1), this->only(Fault::current_sensor));
}

TYPED_TEST(ProtectionOf, APhaseThatDoesNotAnswerAndLeavesZeroNowAndThenIsASensor) {
  using T = TypeParam;
  for (const int every : {2, 19, 40}) {
    this->protection = Protection<T>{typename Protection<T>::Parameters{}};
    AnsweringLoad<T> load;
    FaultSet faults;
    for (int k = 0; k < 800 && !faults.any(); ++k) {
      faults = this->protection.step(load.next(0.0, k % every == 0 ? 4.0 : 0.0));
    }
    EXPECT_EQ(faults, this->only(every < 20 ? Fault::current_sensor : Fault::open_phase)) << every;
  }
}

// 21 periods a turn, in steady state: the voltage turns with the back-EMF and moves the currents by little.
// The model's rotor flux may be wrong by 30 %.
TYPED_TEST(ProtectionOf, AHealthyMachineUnderASmoothVoltageShowsNoFault) {
  using T = TypeParam;
  const SteadyMachine steady = SteadyMachine::of_torque({}, 0.08, 6000.0, 1.0);
  for (const double share : {1.0, 0.7, 1.3}) {
    Protection<T> monitored{
        {.dc_over_voltage = T(3000), .over_speed = T(7000), .speed_range = T(1e4), .speed_error = T(1e4)}};
    FaultSet faults;
    for (int n = 0; n < 400; ++n) {
      const SpaceVector<double> psi_r = share * steady.psi_r(double(n) * SteadyMachine::dt);
      faults |= monitored.step(steady.template measurement<T>(n), {.psi_r = {T(psi_r.alpha), T(psi_r.beta)}});
    }
    EXPECT_FALSE(faults.any()) << share;
  }
}

TYPED_TEST(ProtectionOf, ASpeedThatJumpsIsAFaultWithTheGatesDriven) {
  using T = TypeParam;
  for (const T sign : {T(-1), T(1)}) {
    this->restart();
    Measurement<T> m = this->healthy();
    m.applied = this->driven();
    m.omega_m = sign * T(50);
    EXPECT_FALSE(this->protection.step(m).any()) << "the first one has nothing to jump from";
    m.omega_m = sign * T(84.9);
    this->change_current(m);
    EXPECT_FALSE(this->protection.step(m).any()) << "just inside";
    m.omega_m = sign * T(49.8);
    this->change_current(m);
    EXPECT_EQ(this->protection.step(m), this->only(Fault::speed_sensor));
    m.applied = GatePattern{gates_off, 25'000};
    m.omega_m = sign * T(100);
    EXPECT_FALSE(this->protection.step(m).any());
  }
}

TYPED_TEST(ProtectionOf, FluxThatWasThereAndIsGoneUnderTorqueIsAFaultAfterItsTime) {
  using T = TypeParam;
  const Measurement<T> m = this->healthy();
  ProtectionInputs<T> drive{
      .makes_torque = true, .torque_reference = T(7.6), .flux_reference = T(1.1), .psi_s = T(0.1)};
  const auto run = [&](int periods) {
    FaultSet faults;
    for (int k = 0; k < periods; ++k) faults = this->protection.step(m, drive);
    return faults;
  };
  EXPECT_FALSE(run(20000).any()) << "it was not built yet";
  drive.psi_s = T(0.9);
  run(1);
  drive.psi_s = T(0.551);
  EXPECT_FALSE(run(20000).any()) << "just inside";
  drive.psi_s = T(0.549);
  EXPECT_FALSE(run(7999).any());
  EXPECT_EQ(run(1), this->only(Fault::flux_lost)) << "200 ms";
  drive.torque_reference = T(-7.4);
  EXPECT_FALSE(run(20000).any()) << "a small torque";
  drive.torque_reference = T(-7.6);
  EXPECT_EQ(run(8000), this->only(Fault::flux_lost));
  drive.makes_torque = false;
  EXPECT_FALSE(run(1).any());
}

/// A steady machine, whose speed may be read wrong, read once a period by joined reads.
template <class T>
class LinkedMachine {
 public:
  LinkedMachine(unsigned seed, double omega_m) : steady_{machine(omega_m)}, reads_{seed} {}

  /// Faults within this time [s], with an error of the speed [rad/s].
  FaultSet run(Protection<T>& protection, double seconds, double speed_error = 0.0) {
    FaultSet faults;
    for (auto left = long(seconds / SteadyMachine::dt); left > 0 && !faults.any(); --left) {
      Measurement<T> m = reads_.read([this] { return steady_.measurement<T>(++n_); });
      m.omega_m += T(speed_error);
      faults = protection.step(m, inputs());
    }
    EXPECT_TRUE(reads_.fits());
    return faults;
  }

 private:
  static SteadyMachine machine(double omega_m) {
    return SteadyMachine::of_torque(InductionMachineParameters<double>{}, 1.0, omega_m, 15.0);
  }
  [[nodiscard]] ProtectionInputs<T> inputs() const {
    const InductionMachineParameters<double> p{};
    const double t = double(n_) * SteadyMachine::dt;
    const SpaceVector<double> psi_r = steady_.psi_r(t);
    const double psi_s = magnitude(p.k_r() * psi_r + p.sigma_l_s() * steady_.i_s(t));
    return {.makes_torque = true,
            .torque_reference = T(15),
            .flux_reference = T(psi_s),
            .torque = T(15),
            .psi_s = T(psi_s),
            .psi_r = {T(psi_r.alpha), T(psi_r.beta)}};
  }

  SteadyMachine steady_;
  JoinedReads<T> reads_;
  std::int64_t n_{0};
};

TYPED_TEST(ProtectionOf, ReadsOfNoneOrSeveralRecordsLoseNoCheckOfTheSpeed) {
  using T = TypeParam;
  typename Protection<T>::Parameters p;
  p.dc_over_voltage = T(2500);
  for (const unsigned seed : {1U, 2U, 3U}) {
    for (const double omega_m : {-300.0, 60.0, 300.0}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << omega_m << " rad/s");
      Protection<T> checks{p};
      LinkedMachine<T> machine{seed, omega_m};
      EXPECT_FALSE(machine.run(checks, 0.2).any());
      EXPECT_FALSE(machine.run(checks, 0.1, 20.0).any()) << "just inside the 28 rad/s";
      EXPECT_FALSE(machine.run(checks, 0.003, 34.0).any());
      EXPECT_EQ(machine.run(checks, 0.02, 34.0), this->only(Fault::speed_sensor));
      EXPECT_EQ(checks.unchecked_periods(), 0U);
    }
  }
}

TYPED_TEST(ProtectionOf, ReadsOfNoneOrSeveralRecordsLoseNoCheckOfTheCurrents) {
  using T = TypeParam;
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto run = [&](double share, double offset) {
      Protection<T> checks{typename Protection<T>::Parameters{}};
      AnsweringLoad<T> load;
      JoinedReads<T> reads{seed};
      FaultSet faults;
      for (int k = 0; k < 800; ++k) {
        faults |= checks.step(reads.read([&] { return load.next(share, offset); }));
      }
      EXPECT_EQ(checks.unchecked_periods(), 0U);
      return faults;
    };
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    EXPECT_FALSE(run(1.0, 0.0).any());
    EXPECT_FALSE(run(0.45, 0.0).any()) << "just inside the smallest response of 0.35";
    EXPECT_EQ(run(0.0, 0.0), this->only(Fault::open_phase));
    EXPECT_EQ(run(0.0, 2.1), this->only(Fault::current_sensor));
  }
}

// The same reading twice is one that violates the rule, not two.
TYPED_TEST(ProtectionOf, AReadingThatIsRepeatedCountsOnce) {
  using T = TypeParam;
  Measurement<T> m = this->healthy();
  m.applied = this->driven();
  m.i_abc.c = T(0);
  Measurement<T> again = m;
  again.applied = GatePattern{m.applied.last_state(), 0};
  EXPECT_FALSE(this->protection.step(m).test(Fault::current_sum));
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(this->protection.step(again).test(Fault::current_sum));
  EXPECT_FALSE(this->protection.step(m).test(Fault::current_sum));
  EXPECT_TRUE(this->protection.step(m).test(Fault::current_sum));
  EXPECT_TRUE(this->protection.step(again).test(Fault::current_sum)) << "it is present still";
}

TYPED_TEST(ProtectionOf, TimesAreCountedByThePeriodsBeforeAReading) {
  using T = TypeParam;
  ProtectionInputs<T> drive{
      .makes_torque = true, .torque_reference = T(60), .flux_reference = T(1.1), .psi_s = T(1)};
  Measurement<T> m = this->healthy();
  (void)this->protection.step(m, drive);
  drive.psi_s = T(0.1);
  m.applied = GatePattern{switch_states[0], 50'000};
  for (int k = 0; k < 3999; ++k) ASSERT_FALSE(this->protection.step(m, drive).test(Fault::flux_lost)) << k;
  EXPECT_TRUE(this->protection.step(m, drive).test(Fault::flux_lost)) << "200 ms";
}

TYPED_TEST(ProtectionOf, WhatTheChecksLeaveOutIsCounted) {
  using T = TypeParam;
  Measurement<T> m = this->healthy();
  const auto after = [&](GatePattern applied, double omega_m = 100.0) {
    m.applied = applied;
    m.omega_m = T(omega_m);
    (void)this->protection.step(m);
    return this->protection.unchecked_periods();
  };
  EXPECT_EQ(after({}), 0U);
  EXPECT_EQ(after({gates_off, 1'000'000}), 0U) << "with the gates off there is nothing to check";
  EXPECT_EQ(after(this->driven()), 0U);
  EXPECT_EQ(after({switch_states[1], 0}), 0U);
  EXPECT_EQ(after({switch_states[1], 75'000}), 0U);
  // Two pole pairs: a quarter of a turn is π/4 of the shaft, 7.85 ms at 100 rad/s.
  EXPECT_EQ(after({switch_states[1], 7'800'000}), 0U);
  EXPECT_EQ(after({switch_states[1], 7'900'000}), 316U);
  GatePattern in_part{switch_states[1], 30'000};
  in_part.append({gates_off, 70'000});
  EXPECT_EQ(after(in_part), 320U);
}

TYPED_TEST(ProtectionOf, TheWindingsTemperatureTakesTheTorqueAwayAndTrips) {
  using T = TypeParam;
  using Parameters = typename Protection<T>::Parameters;
  Parameters p;
  p.period_ns = 250'000;
  p.winding = {.nominal_current = T(10), .nominal_rise = T(100), .time_constant = T(10), .ambient = T(30)};
  Protection<T> monitored{p};
  EXPECT_EQ(monitored.available_share(), T(1));
  // 13 A peak and 9.2 A RMS: 84.5 K above 30 °C, below the warning.
  Measurement<T> m = this->healthy();
  m.i_abc = {T(13), T(-6.5), T(-6.5)};
  const auto run = [&](double seconds) {
    FaultSet faults;
    for (int k = 0; k < int(seconds / 250e-6); ++k) faults |= monitored.step(m);
    return faults;
  };
  EXPECT_FALSE(run(100).any());
  EXPECT_EQ(monitored.available_share(), T(1));
  // To 142.6 °C: half way from 130 to 155.
  m.i_abc = {T(15), T(-7.5), T(-7.5)};
  EXPECT_FALSE(run(100).any());
  EXPECT_NEAR(monitored.available_share(), 0.5, 0.02);
  m.i_abc = {T(15.9), T(-7.95), T(-7.95)};  // 156.4 °C
  EXPECT_EQ(run(100), this->only(Fault::over_temperature));
  EXPECT_EQ(monitored.available_share(), T(0));
}

TYPED_TEST(ProtectionOf, RefusesMonitorsThatCannotWork) {
  using T = TypeParam;
  using Parameters = typename Protection<T>::Parameters;
  for (const T bad : {T(-1), this->nan, this->infinity}) {
    EXPECT_NE((Parameters{.dc_under_voltage = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.current_sum = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.current_gain_tolerance = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.current_jump = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.current_response = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.current_noise = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.zero_current = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.speed_jump = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.speed_error = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.flux_lost_share = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.flux_lost_torque = bad}.validate()), nullptr);
  }
  EXPECT_NE((Parameters{.speed_error_ns = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.flux_lost_ns = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.winding_warning = T(155), .winding_trip = T(155)}.validate()), nullptr);
  EXPECT_NE((Parameters{.winding_warning = T(40)}.validate()), nullptr);
  Parameters p;
  p.period_ns = 0;
  EXPECT_NE(p.validate(), nullptr);
}

TYPED_TEST(ProtectionOf, RefusesTripLevelsThatAreNone) {
  using T = TypeParam;
  using Parameters = typename Protection<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), this->nan, this->infinity}) {
    EXPECT_NE((Parameters{.over_current = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.dc_over_voltage = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.over_speed = bad}.validate()), nullptr);
  }
}

}  // namespace
}  // namespace sextant
