#include "sextant/drive/drive.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "drive/fake_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int32_t period_ns = 25'000;
constexpr unsigned seed = 20240508;

template <class T>
class DriveOf : public testing::Test {
 protected:
  using DriveParameters = typename Drive<T>::Parameters;
  static constexpr T nan = std::numeric_limits<T>::quiet_NaN();

  DriveOf() {
    measurement.u_dc = T(530);
    measurement.i_abc = {T(5), T(-2), T(-3)};
    measurement.omega_m = T(10);
    restart();
  }

  void receive(T torque, bool enable, bool fault_reset = false) {
    TorqueCommand<T>& c = request.command;
    c.torque = torque;
    c.torque_limit = T(150);
    c.enable = enable;
    c.fault_reset = fault_reset;
    c.received_ns = t_ns;
    c.e2e = E2eState::valid;
    ++c.sequence;
  }

  DriveOutput<T> step() {
    const auto out = drive->step(t_ns, measurement, request);
    const bool on = gates_are_on(out.telemetry.state);
    EXPECT_EQ(out.telemetry.state, drive->state());
    EXPECT_EQ(out.pattern.last_state() != gates_off, on) << to_string(out.telemetry.state);
    EXPECT_EQ(out.pattern.duration_ns(), period_ns);
    EXPECT_FALSE(on && out.telemetry.lockout);
    EXPECT_FALSE(on && out.telemetry.active.any());
    EXPECT_FALSE(on && out.telemetry.latched.any());
    t_ns += period_ns;
    return out;
  }

  DriveOutput<T> run(std::int64_t duration) {
    DriveOutput<T> out;
    for (const std::int64_t end = t_ns + duration; t_ns < end;) out = step();
    return out;
  }

  void start(T torque) {
    step();
    receive(T(0), false);
    run(ms);
    ASSERT_EQ(drive->state(), DriveState::ready);
    receive(torque, true);
    run(ms);
    ASSERT_EQ(drive->state(), DriveState::torque);
    ASSERT_EQ(controller->last_reference.torque, torque);
  }

  /// A drive as after power-up, with a machine that has its flux.
  void restart(const DriveParameters& parameters = {}) {
    controller.emplace();
    controller->estimate().psi_s = {T(1.1), T(0)};
    drive.emplace(parameters, *controller);
    request = {};
  }

  std::optional<test::FakeController<T>> controller{};
  std::optional<Drive<T>> drive{};
  std::int64_t t_ns{5 * ms};
  Measurement<T> measurement{};
  DriveRequest<T> request{};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DriveOf, Scalars);

TYPED_TEST(DriveOf, EnableAtPowerUpWithoutADisableNeverTurnsTheGatesOn) {
  for (int frame = 0; frame < 50; ++frame) {
    this->receive(TypeParam(15), true);
    const auto out = this->run(10 * ms);
    EXPECT_EQ(out.telemetry.state, DriveState::standby);
    EXPECT_TRUE(out.telemetry.lockout);
  }
  EXPECT_EQ(this->controller->last_reference.mode, ControlMode::off);
}

TYPED_TEST(DriveOf, ATorqueCommandReachesTheControllerAfterADisable) {
  using T = TypeParam;
  this->start(T(15));
  EXPECT_EQ(this->controller->last_reference.mode, ControlMode::torque);
  this->receive(T(-20), true);
  this->run(ms);
  EXPECT_EQ(this->controller->last_reference.torque, T(-20));
  this->receive(T(-20), false);
  EXPECT_EQ(this->step().telemetry.state, DriveState::ready);
  EXPECT_EQ(this->controller->last_reference.mode, ControlMode::off);
}

TYPED_TEST(DriveOf, ARampToZeroHasACauseWhileItLasts) {
  using T = TypeParam;
  const CommandLimits<T> limits{};
  this->start(T(15));
  EXPECT_EQ(this->step().telemetry.derating_cause, DeratingCause::none);
  this->run(limits.timeout_ns + ms);
  const auto late = this->step();
  EXPECT_EQ(late.telemetry.state, DriveState::torque);
  EXPECT_LT(late.telemetry.torque_reference, T(15));
  EXPECT_EQ(late.telemetry.derating_cause, DeratingCause::command_timeout);
  this->receive(T(15), true);
  EXPECT_EQ(this->step().telemetry.derating_cause, DeratingCause::none);
  this->request.status_age_ns = limits.status_timeout_ns + 1;
  EXPECT_EQ(this->step().telemetry.derating_cause, DeratingCause::status_timeout);
  this->request.status_age_ns = 0;
  this->request.shutdown = true;
  EXPECT_EQ(this->step().telemetry.derating_cause, DeratingCause::shutdown);
  this->run(limits.zero_ramp_ns + ms);
  const auto end = this->step();
  EXPECT_EQ(end.telemetry.state, DriveState::shutdown);
  EXPECT_EQ(end.telemetry.derating_cause, DeratingCause::gates_are_off);
}

TYPED_TEST(DriveOf, NoRampIsToldWhileTheFluxBuildsUp) {
  using T = TypeParam;
  this->controller->estimate().magnetised = false;
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(15), true);
  const auto out = this->run(ms);
  ASSERT_EQ(out.telemetry.state, DriveState::magnetising);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::none);
  // Nor in the period in which it is ready, when the torque was still held at zero.
  this->controller->estimate().magnetised = true;
  const auto first = this->step();
  ASSERT_EQ(first.telemetry.state, DriveState::torque);
  EXPECT_EQ(first.telemetry.derating_cause, DeratingCause::none);
}

// A plant at the other end of a link, whose first measurement is on its way.
TYPED_TEST(DriveOf, WaitsInInitForTheFirstValidMeasurement) {
  this->measurement.plausible = false;
  const auto waits = this->run(50 * ms);
  EXPECT_EQ(waits.telemetry.state, DriveState::init);
  EXPECT_FALSE(waits.telemetry.active.any() || waits.telemetry.latched.any());
  this->measurement.plausible = true;
  EXPECT_EQ(this->step().telemetry.state, DriveState::standby);
  this->measurement.plausible = false;
  const auto lost = this->step();
  EXPECT_EQ(lost.telemetry.state, DriveState::fault);
  EXPECT_TRUE(lost.telemetry.latched.test(Fault::measurement_invalid));
}

TYPED_TEST(DriveOf, AFaultOfTheFirstValidMeasurementCounts) {
  this->measurement.plausible = false;
  this->step();
  this->measurement.plausible = true;
  this->measurement.u_dc = TypeParam(1000);
  EXPECT_EQ(this->step().telemetry.state, DriveState::fault);
}

// Both come before the control thread looks again, so that it sees the enable only.
TYPED_TEST(DriveOf, ADisableThatAnEnableOverwroteTurnsTheGatesOffForAPeriodAndTorqueStartsFromZero) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.command.torque_rate = T(1000);
  this->restart(parameters);
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(20), true);
  ASSERT_EQ(this->run(30 * ms).telemetry.torque_reference, T(20));
  this->receive(T(20), false);
  ++this->request.command.disables;
  this->receive(T(20), true);
  EXPECT_EQ(this->step().telemetry.state, DriveState::ready);
  const auto out = this->step();
  EXPECT_EQ(out.telemetry.state, DriveState::torque);
  EXPECT_NEAR(out.telemetry.torque_reference, T(0.025), T(1e-6));
}

TYPED_TEST(DriveOf, ADisableAndAnEnableInOnePeriodEachStartTheTorqueFromZero) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.command.torque_rate = T(1000);
  this->restart(parameters);
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(20), true);
  ASSERT_EQ(this->run(30 * ms).telemetry.torque_reference, T(20));
  this->receive(T(20), false);
  EXPECT_EQ(this->step().telemetry.state, DriveState::ready);
  this->receive(T(20), true);
  EXPECT_NEAR(this->step().telemetry.torque_reference, T(0.025), T(1e-6));
}

TYPED_TEST(DriveOf, TheControllerIsSteppedInEveryPeriod) {
  this->run(ms);
  EXPECT_EQ(this->controller->steps, 40);
}

TYPED_TEST(DriveOf, AMeasurementThatNoSensorReadsTurnsTheGatesOffAtOnceAndIsKeptFromTheController) {
  using T = TypeParam;
  const int unusable = 5;
  for (int kind = 0; kind < unusable; ++kind) {
    SCOPED_TRACE(kind);
    this->restart();
    this->start(T(15));
    const Measurement<T> good = this->measurement;
    if (kind == 0) this->measurement.i_abc.b = this->nan;
    if (kind == 1) this->measurement.omega_m = std::numeric_limits<T>::infinity();
    if (kind == 2) this->measurement.plausible = false;
    if (kind == 3) this->measurement.i_abc = {T(1e30), T(-1e30), T(0)};
    if (kind == 4) this->measurement.u_dc = T(1e30);
    const auto out = this->step();
    EXPECT_EQ(out.telemetry.state, DriveState::fault);
    EXPECT_EQ(out.pattern.last_state(), gates_off);
    EXPECT_TRUE(out.telemetry.latched.test(Fault::measurement_invalid));
    const Measurement<T>& seen = this->controller->last_measurement;
    EXPECT_EQ(seen.i_abc, ThreePhase<T>{});
    EXPECT_EQ(seen.u_dc, good.u_dc);
    EXPECT_EQ(seen.omega_m, good.omega_m);
    EXPECT_EQ(seen.applied, (GatePattern{gates_off, period_ns}));
    this->measurement = good;
    EXPECT_EQ(this->step().telemetry.state, DriveState::fault);
    EXPECT_EQ(this->controller->last_measurement.i_abc, ThreePhase<T>{}) << "nor any reading in FAULT";
    EXPECT_EQ(this->controller->restarts, 0);
    this->receive(T(0), false, true);
    EXPECT_EQ(this->step().telemetry.state, DriveState::standby);
    EXPECT_EQ(this->controller->restarts, 1) << "from the state of a start";
    EXPECT_EQ(this->controller->last_measurement.i_abc, good.i_abc);
  }
}

TYPED_TEST(DriveOf, TheFluxOfADriveInFaultTurnsByTheMeasuredSpeedUnlessThatIsInDoubt) {
  using T = TypeParam;
  const auto seen_speed = [this](T speed) {
    this->measurement.omega_m = speed;
    this->step();
    return this->controller->last_measurement.omega_m;
  };
  this->start(T(15));
  this->request.external.set(Fault::overrun);
  EXPECT_EQ(seen_speed(T(11)), T(11));
  ASSERT_EQ(this->drive->state(), DriveState::fault);
  EXPECT_EQ(seen_speed(T(12)), T(12));
  EXPECT_EQ(seen_speed(T(1000)), T(12)) << "over-speed";
  EXPECT_EQ(seen_speed(this->nan), T(12));
  EXPECT_EQ(seen_speed(T(13)), T(13));
}

TYPED_TEST(DriveOf, OverCurrentAndOverVoltageTurnTheGatesOffInTheSamePeriod) {
  using T = TypeParam;
  this->start(T(15));
  this->measurement.i_abc.c = T(-201);
  const auto out = this->step();
  EXPECT_EQ(out.telemetry.state, DriveState::fault);
  EXPECT_EQ(out.telemetry.first_fault, Fault::over_current);
  EXPECT_EQ(out.telemetry.torque_reference, T(0));
  this->measurement.u_dc = T(701);
  EXPECT_TRUE(this->step().telemetry.latched.test(Fault::dc_over_voltage));
}

TYPED_TEST(DriveOf, ExternalFaultsTurnTheGatesOffInTheSamePeriod) {
  this->start(TypeParam(15));
  this->request.external.set(Fault::watchdog);
  EXPECT_EQ(this->step().telemetry.state, DriveState::fault);
}

TYPED_TEST(DriveOf, TheWayOutOfAFaultIsResetThenDisableThenEnable) {
  using T = TypeParam;
  this->start(T(15));
  const ThreePhase<T> usual = this->measurement.i_abc;
  this->measurement.i_abc = {T(300), T(-150), T(-150)};
  this->step();
  // While the fault is present a reset is refused.
  this->receive(T(0), false, true);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::fault);
  this->measurement.i_abc = usual;
  // Neither enable nor disable leaves the fault.
  this->receive(T(0), false);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::fault);
  this->receive(T(15), true);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::fault);
  this->receive(T(0), false, true);
  auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::standby);
  EXPECT_FALSE(out.telemetry.latched.any());
  EXPECT_EQ(out.telemetry.fault_total, 1U);
  // The disable that was seen during the fault does not count.
  this->receive(T(15), true);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::standby);
  this->receive(T(0), false);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::ready);
  this->receive(T(15), true);
  out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::torque);
  EXPECT_EQ(this->controller->last_reference.torque, T(15));
}

TYPED_TEST(DriveOf, AfterAFaultTorqueStartsFromZero) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.command.torque_rate = T(1000);
  this->restart(parameters);
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(20), true);
  this->run(30 * ms);
  this->request.external.set(Fault::overrun);
  this->step();
  this->request.external = {};
  this->receive(T(0), false, true);
  this->step();
  this->receive(T(0), false);
  this->step();
  this->step();
  this->receive(T(20), true);
  EXPECT_LT(std::abs(this->step().telemetry.torque_reference), T(0.1));
}

TYPED_TEST(DriveOf, SilenceIsZeroTorqueWithinSixtyMillisecondsAndAFaultAfterTwoHundred) {
  using T = TypeParam;
  this->start(T(150));
  const std::int64_t received = this->request.command.received_ns;
  while (this->t_ns - received < 60 * ms) this->step();
  EXPECT_EQ(this->controller->last_reference.torque, T(0));
  EXPECT_EQ(this->drive->state(), DriveState::torque);
  while (this->t_ns - received <= 200 * ms) this->step();
  EXPECT_EQ(this->step().telemetry.first_fault, Fault::command_lost);
  EXPECT_EQ(this->drive->state(), DriveState::fault);
}

TYPED_TEST(DriveOf, MissedPeriodsDoNotStretchTheRampToZero) {
  using T = TypeParam;
  this->start(T(150));
  const std::int64_t received = this->request.command.received_ns;
  while (this->t_ns - received < 60 * ms) {
    this->step();
    this->t_ns += 3 * period_ns;
  }
  EXPECT_EQ(this->controller->last_reference.torque, T(0));
}

TYPED_TEST(DriveOf, AClockThatIsSetBackStopsNoCommandsAge) {
  using T = TypeParam;
  this->start(T(150));
  this->t_ns -= 3'600'000 * ms;
  const std::int64_t back_ns = this->t_ns;
  EXPECT_EQ(this->run(39 * ms).telemetry.torque_reference, T(150));
  EXPECT_EQ(this->run(21 * ms).telemetry.torque_reference, T(0));
  EXPECT_EQ(this->run(141 * ms).telemetry.first_fault, Fault::command_lost);
  EXPECT_EQ(this->t_ns - back_ns, 201 * ms);
}

TYPED_TEST(DriveOf, AClockThatIsSetForwardLosesTheCommand) {
  using T = TypeParam;
  this->start(T(150));
  this->t_ns += 3'600'000 * ms;
  const auto out = this->step();
  EXPECT_EQ(out.telemetry.state, DriveState::fault);
  EXPECT_EQ(out.telemetry.first_fault, Fault::command_lost);
}

TYPED_TEST(DriveOf, NoClockIsTooStrange) {
  using T = TypeParam;
  using Limits = std::numeric_limits<std::int64_t>;
  std::mt19937_64 random{seed};
  for (int k = 0; k < 20'000; ++k) {
    const auto any = std::int64_t(random());
    const std::array times{Limits::min(), Limits::max(), std::int64_t{0}, any, any >> 20U, this->t_ns};
    this->t_ns = times[random() % times.size()];
    this->receive(T(15), random() % 4 != 0, random() % 8 == 0);
    this->request.command.received_ns = times[random() % times.size()];
    const auto out = this->drive->step(this->t_ns, this->measurement, this->request);
    ASSERT_TRUE(std::isfinite(out.telemetry.torque_reference));
    ASSERT_LE(std::abs(out.telemetry.torque_reference), T(15));
    ASSERT_EQ(out.telemetry.t_ns, this->t_ns);
  }
}

TYPED_TEST(DriveOf, CommandFaultsOfAnIdleDriveDoNotLatchButNothingIsEnabledUnderThem) {
  using T = TypeParam;
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->request.command.bus_off = true;
  this->receive(T(15), true);
  const auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::ready);
  EXPECT_FALSE(out.telemetry.latched.any());
}

TYPED_TEST(DriveOf, ALostCommandOfAnIdleDriveLeadsBackToStandbyWithoutAFault) {
  this->step();
  this->receive(TypeParam(0), false);
  this->run(ms);
  const auto out = this->run(250 * ms);
  EXPECT_EQ(out.telemetry.state, DriveState::standby);
  EXPECT_TRUE(out.telemetry.lockout);
  EXPECT_EQ(out.telemetry.fault_total, 0U);
}

TYPED_TEST(DriveOf, ShutdownRampsToZeroBeforeTheGatesGoOffForGood) {
  using T = TypeParam;
  this->start(T(100));
  this->request.shutdown = true;
  T last = T(100);
  int periods = 0;
  while (this->drive->state() != DriveState::shutdown && periods < 1000) {
    const auto out = this->step();
    ASSERT_LE(out.telemetry.torque_reference, last);
    last = out.telemetry.torque_reference;
    ++periods;
  }
  EXPECT_NEAR(periods * 0.025, 10, 0.2);
  EXPECT_EQ(last, T(0));
  this->request.shutdown = false;
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(15), true);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::shutdown);
}

TYPED_TEST(DriveOf, ShutdownOfAnIdleDriveIsImmediate) {
  this->step();
  this->request.shutdown = true;
  EXPECT_EQ(this->step().telemetry.state, DriveState::shutdown);
}

TYPED_TEST(DriveOf, WithMagnetiseFirstTorqueWaitsForTheFluxAndStartsFromZero) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.command.torque_rate = T(1000);
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->measurement.omega_m = T(0);
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(15), true);
  const auto out = this->run(30 * ms);
  EXPECT_EQ(out.telemetry.state, DriveState::magnetising);
  EXPECT_EQ(this->controller->last_reference.mode, ControlMode::magnetise);
  this->controller->estimate().magnetised = true;
  EXPECT_EQ(this->step().telemetry.state, DriveState::torque);
  EXPECT_EQ(this->controller->last_reference.torque, T(0));
  // The flux estimate may leave `magnetised` again; torque production does not fall back.
  this->controller->estimate().magnetised = false;
  this->receive(T(15), true);
  this->run(20 * ms);
  EXPECT_EQ(this->drive->state(), DriveState::torque);
  EXPECT_EQ(this->controller->last_reference.torque, T(15));
}

TYPED_TEST(DriveOf, FluxThatNeverComesIsAFaultAfterItsTimeAndNotBefore) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.magnetise_timeout_ns = 300 * ms;
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->measurement.omega_m = T(0);
  this->step();
  const auto hand_shake = [this] {
    this->receive(T(0), false);
    this->run(ms);
    this->receive(T(15), true);
  };
  const auto periods_of_magnetising = [this] {
    int periods = 0;
    while (periods < 100'000 && !this->HasFailure()) {
      if (periods % 400 == 0) this->receive(T(15), true);
      if (this->step().telemetry.state != DriveState::magnetising) break;
      ++periods;
    }
    return periods;
  };
  hand_shake();
  EXPECT_EQ(periods_of_magnetising(), 300 * ms / period_ns);
  EXPECT_EQ(this->drive->state(), DriveState::fault);
  const auto out = this->step();
  EXPECT_EQ(out.telemetry.first_fault, Fault::flux_lost);
  EXPECT_EQ(out.telemetry.fault_total, 1U);
  EXPECT_FALSE(out.telemetry.active.any());
  EXPECT_EQ(this->controller->last_reference.mode, ControlMode::off);

  hand_shake();
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::fault) << "latched";
  this->receive(T(0), false, true);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::standby);
  hand_shake();
  EXPECT_EQ(periods_of_magnetising(), 300 * ms / period_ns) << "the whole time again";
}

TYPED_TEST(DriveOf, FluxThatComesInTheLastMomentIsNoFault) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.magnetise_timeout_ns = 10 * ms;
  for (const int late : {-1, 0}) {
    this->restart(parameters);
    this->controller->estimate().magnetised = false;
    this->measurement.omega_m = T(0);
    this->step();
    this->receive(T(0), false);
    this->run(ms);
    this->receive(T(15), true);
    while (this->step().telemetry.state != DriveState::magnetising && !this->HasFailure()) {
    }
    for (std::int64_t k = 1; k < 10 * ms / period_ns + late; ++k) {
      ASSERT_EQ(this->step().telemetry.state, DriveState::magnetising);
    }
    this->controller->estimate().magnetised = true;
    EXPECT_EQ(this->step().telemetry.state, DriveState::torque);
    EXPECT_EQ(this->run(20 * ms).telemetry.fault_total, 0U);
  }
}

// 15 ms of a time of 10 ms, in pieces.
TYPED_TEST(DriveOf, TheTimeForMagnetisingBeginsAnewWithEachEnable) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.magnetise_timeout_ns = 10 * ms;
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->measurement.omega_m = T(0);
  this->step();
  for (int k = 0; k < 3; ++k) {
    this->receive(T(0), false);
    EXPECT_EQ(this->run(ms).telemetry.state, DriveState::ready);
    this->receive(T(15), true);
    EXPECT_EQ(this->run(5 * ms).telemetry.state, DriveState::magnetising);
  }
}

TYPED_TEST(DriveOf, ATurningMachineIsMagnetisedFirstToo) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->measurement.omega_m = T(100);
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(15), true);
  this->run(ms);
  EXPECT_EQ(this->drive->state(), DriveState::magnetising);
}

TYPED_TEST(DriveOf, WithoutMagnetiseFirstTorqueStartsAtOnce) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.magnetise_first = false;
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->start(T(15));
  EXPECT_FALSE(this->controller->estimate().magnetised);
}

TYPED_TEST(DriveOf, WhereTheVoltageIsShortTheTorqueIsDeratedButBrakingIsNot) {
  using T = TypeParam;
  this->start(T(100));
  EXPECT_EQ(this->step().telemetry.derating_cause, DeratingCause::none);
  this->measurement.omega_m = T(250);
  auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::derated);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::voltage_limit);
  EXPECT_NEAR(out.telemetry.torque_reference, T(60.2), T(0.3));
  EXPECT_EQ(out.telemetry.torque_reference, out.telemetry.torque_motoring);
  this->receive(T(-100), true);
  out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::torque);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::none);
  EXPECT_EQ(out.telemetry.torque_reference, T(-100));
  EXPECT_EQ(out.telemetry.torque_regenerating, T(150));
}

TYPED_TEST(DriveOf, BeyondBaseSpeedTheFluxIsWeakenedAndTheGatesStayOn) {
  using T = TypeParam;
  for (const T torque : {T(20), T(0), T(-50)}) {
    SCOPED_TRACE(torque);
    this->restart();
    this->start(torque);
    this->controller->estimate().torque = torque;
    EXPECT_EQ(this->controller->last_reference.flux_share, T(1));
    this->measurement.omega_m = T(300);
    this->receive(torque, true);
    auto out = this->run(30 * ms);
    EXPECT_EQ(out.telemetry.state, DriveState::torque);
    EXPECT_EQ(out.telemetry.torque_reference, torque);
    // Without torque 306 V/(600 rad/s); braking needs less voltage.
    const T flux = T(1.1) * this->controller->last_reference.flux_share;
    if (torque == T(0)) {
      EXPECT_NEAR(flux, T(0.51), T(0.005));
    } else {
      EXPECT_EQ(flux > T(0.51), torque < T(0));
      EXPECT_NEAR(flux, T(0.51), T(0.12));
    }
    this->measurement.omega_m = T(50);
    this->receive(torque, true);
    this->run(35 * ms);
    this->receive(torque, true);
    this->run(10 * ms);
    EXPECT_EQ(this->controller->last_reference.flux_share, T(1));
  }
}

TYPED_TEST(DriveOf, TheFluxReferenceSlewsWithTheGatesOnAndJumpsWithThemOff) {
  using T = TypeParam;
  this->start(T(0));
  this->measurement.omega_m = T(150);
  T before = this->controller->last_reference.flux_share;
  for (int k = 0; k < 200; ++k) {
    this->step();
    const T now = this->controller->last_reference.flux_share;
    EXPECT_LE(before - now, T(2.2e-3)) << "1/(2 · 5.8 ms) of it in 25 µs";
    before = now;
  }
  EXPECT_NEAR(before, T(306.0 / 300.0 / 1.1), T(0.01));
  this->receive(T(0), false);
  this->run(ms);
  this->measurement.omega_m = T(10);
  this->step();
  EXPECT_EQ(this->controller->last_reference.flux_share, T(1));
}

// Six steps turn 2/π · 530 V/(600 rad/s) at most; a steady state has 306 V for it.
TYPED_TEST(DriveOf, TheFluxReferenceFallsAtOnceToWhatTheLinkHolds) {
  using T = TypeParam;
  this->start(T(0));
  this->measurement.omega_m = T(300);
  this->run(ms / 20);
  EXPECT_LT(T(1.1) * this->controller->last_reference.flux_share, T(0.5625));
  EXPECT_GT(T(1.1) * this->controller->last_reference.flux_share, T(0.55));
}

TYPED_TEST(DriveOf, TheOptimumOfTheFluxCountsWhileTorqueIsMadeAndNothingLimitsItNow) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.motor.optimal_flux.optimum = FluxOptimum::max_torque_per_ampere;
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(0), true);
  EXPECT_EQ(this->run(50 * ms).telemetry.state, DriveState::magnetising);
  EXPECT_EQ(this->controller->last_reference.flux_share, T(1)) << "the machine gets its whole flux first";
  this->controller->estimate().magnetised = true;
  const auto run_on = [&](T torque, int commands) {
    for (int k = 0; k < commands; ++k) {
      this->receive(torque, true);
      this->run(40 * ms);
    }
  };
  run_on(T(0), 60);
  EXPECT_NEAR(this->controller->last_reference.flux_share, T(0.4), T(2e-3));
  // The estimate says that there is little flux: the torque is limited by it, and all of it is wanted.
  this->controller->estimate().psi_s = {T(0.44), T(0)};
  this->receive(T(150), true);
  auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::derated);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::voltage_limit);
  EXPECT_LT(out.telemetry.torque_motoring, T(100));
  EXPECT_EQ(out.telemetry.torque_regenerating, T(150));
  this->controller->estimate().psi_s = {T(1.1), T(0)};
  run_on(T(150), 2);
  out = this->step();
  EXPECT_EQ(out.telemetry.state, DriveState::torque);
  EXPECT_EQ(out.telemetry.torque_motoring, T(150));
  EXPECT_EQ(this->controller->last_reference.flux_share, T(1));
}

TYPED_TEST(DriveOf, TheTorqueStaysWithinTheCurrentLimitByTheCurrentThatFlows) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.motor.capability.current_limit = T(60);
  this->restart(parameters);
  this->start(T(150));
  this->measurement.i_abc = {T(40), T(-20), T(-20)};  // along the flux
  auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::derated);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::current_limit);
  EXPECT_NEAR(out.telemetry.torque_reference, T(3 * 1.1) * std::sqrt(T(60 * 60 - 40 * 40)), T(0.01));
  EXPECT_EQ(out.telemetry.torque_motoring, out.telemetry.torque_reference);
  EXPECT_EQ(out.telemetry.torque_regenerating, T(150)) << "nothing has limited that side";
  this->measurement.i_abc = {T(61), T(-30.5), T(-30.5)};
  EXPECT_EQ(this->run(ms).telemetry.torque_reference, T(0));
  this->measurement.i_abc = {T(10), T(-5), T(-5)};
  out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::torque);
  EXPECT_EQ(out.telemetry.torque_reference, T(150));
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::none);
}

TYPED_TEST(DriveOf, AMeanTorqueThatMissesItsReferenceAtTheVoltageLimitLowersFluxAndAvailableTorque) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.torque_monitor.limit = T(1e6);
  this->restart(parameters);
  this->measurement.omega_m = T(250);
  this->measurement.applied = GatePattern{switch_states[0], period_ns};
  this->start(T(50));
  this->controller->estimate().torque = T(49);
  this->run(30 * ms);
  const T flux = this->controller->last_reference.flux_share;
  const T available = this->run(5 * ms).telemetry.torque_motoring;
  EXPECT_EQ(this->controller->last_reference.flux_share, flux);
  this->controller->estimate().torque = T(35);
  this->receive(T(50), true);
  this->run(20 * ms);
  EXPECT_LT(this->controller->last_reference.flux_share, T(0.97) * flux);
  EXPECT_LT(this->step().telemetry.torque_motoring, T(0.9) * available);
}

// With 0.475 of the flux an active vector adds 2.9 N·m in a period.
TYPED_TEST(DriveOf, AMissBelowWhatAVectorAddsLowersTheFluxOnlyWhereTheControllerHoldsItsMeanTorque) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  parameters.torque_monitor.limit = T(1e6);
  for (const bool holds : {true, false}) {
    SCOPED_TRACE(holds);
    this->restart();
    this->controller->holds = holds;
    this->drive.emplace(parameters, *this->controller);
    this->measurement.omega_m = T(250);
    this->measurement.applied = GatePattern{switch_states[0], period_ns};
    this->start(T(50));
    this->controller->estimate().torque = T(50);
    this->run(30 * ms);
    const T flux = this->controller->last_reference.flux_share;
    EXPECT_NEAR(flux, T(0.475), T(0.01));
    this->controller->estimate().torque = T(47.5);
    for (int command = 0; command < 4; ++command) {
      this->receive(T(50), true);
      this->run(30 * ms);
    }
    const T lowered = this->controller->last_reference.flux_share;
    EXPECT_EQ(lowered < T(0.97) * flux, holds) << flux << " to " << lowered;
    if (!holds) {
      EXPECT_EQ(lowered, flux);
    }
  }
}

TYPED_TEST(DriveOf, WithTheGatesOffTheCauseOfTheLimitAreTheGates) {
  using T = TypeParam;
  this->step();
  this->receive(T(0), false);
  const auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::ready);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::gates_are_off);
  EXPECT_EQ(out.telemetry.torque_motoring, T(150)) << "after an enable";
}

TYPED_TEST(DriveOf, WithoutLinkVoltageThereIsNoTorque) {
  using T = TypeParam;
  this->start(T(15));
  this->measurement.u_dc = T(0);
  const auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::derated);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::voltage_limit);
  EXPECT_EQ(out.telemetry.torque_reference, T(0));
  EXPECT_EQ(out.telemetry.torque_motoring, T(0));
  this->measurement.u_dc = T(530);
  EXPECT_EQ(this->run(ms).telemetry.state, DriveState::torque);
}

// The rules on sequences of measurements are tested in the whole drive:
// tests/virtual_time/fault_list_test.cpp.
TYPED_TEST(DriveOf, AMeasurementBeyondATripLevelTripsADriveThatMakesTorque) {
  using T = TypeParam;
  constexpr T beyond = T(1e3);
  const Measurement<T> usual = this->measurement;
  const auto expect_trip = [&](Fault fault, auto&& change) {
    this->restart();
    this->measurement = usual;
    this->start(T(15));
    change(this->measurement);
    const auto out = this->step();
    EXPECT_EQ(out.telemetry.state, DriveState::fault);
    EXPECT_TRUE(out.telemetry.latched.test(fault)) << to_string(fault);
  };
  expect_trip(Fault::over_current, [](Measurement<T>& m) { m.i_abc.a = beyond; });
  expect_trip(Fault::dc_over_voltage, [](Measurement<T>& m) { m.u_dc = beyond; });
  expect_trip(Fault::over_speed, [](Measurement<T>& m) { m.omega_m = beyond; });
}

TYPED_TEST(DriveOf, OverSpeedIsAFaultThatIsLeftByResetDisableEnable) {
  using T = TypeParam;
  for (const T sign : {T(1), T(-1)}) {
    this->restart();
    this->measurement.omega_m = sign * T(10);
    this->start(T(15));
    this->measurement.omega_m = sign * T(487);
    EXPECT_EQ(this->step().telemetry.state, DriveState::torque) << "just inside";
    this->measurement.omega_m = sign * T(487.1);
    auto out = this->step();
    EXPECT_EQ(out.telemetry.state, DriveState::fault);
    EXPECT_EQ(out.telemetry.first_fault, Fault::over_speed);
    this->measurement.omega_m = sign * T(100);
    out = this->run(ms);
    EXPECT_EQ(out.telemetry.state, DriveState::fault) << "latched";
    EXPECT_FALSE(out.telemetry.active.any());
    this->receive(T(0), false, true);
    EXPECT_EQ(this->step().telemetry.state, DriveState::standby);
    this->receive(T(0), false);
    EXPECT_EQ(this->step().telemetry.state, DriveState::ready);
    this->receive(T(15), true);
    EXPECT_EQ(this->step().telemetry.state, DriveState::torque);
  }
}

/// A drive whose machine has no current and little flux: a torque command takes milliseconds by the voltage.
template <class T>
typename Drive<T>::Parameters slow_torque() {
  typename Drive<T>::Parameters parameters;
  parameters.torque_monitor.enabled = false;
  parameters.protection.dc_under_voltage = T(0);
  return parameters;
}

TYPED_TEST(DriveOf, ATorqueThatTheVoltageHoldsShortOfItsReferenceIsDerated) {
  using T = TypeParam;
  for (const T sign : {T(1), T(-1)}) {
    this->restart(slow_torque<T>());
    this->measurement.i_abc = {};
    this->measurement.applied = GatePattern{switch_states[0], period_ns};
    this->start(T(0));
    this->receive(sign * T(100), true);
    auto out = this->run(3 * ms);
    EXPECT_EQ(out.telemetry.state, DriveState::derated);
    EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::voltage_limit);
    EXPECT_EQ(out.telemetry.torque_reference, sign * T(100));
    const T reached = sign * out.telemetry.torque_reached;
    EXPECT_GT(reached, T(1));
    EXPECT_LT(reached, T(90));
    EXPECT_EQ(sign > T(0) ? out.telemetry.torque_motoring : out.telemetry.torque_regenerating, reached);
    EXPECT_EQ(sign > T(0) ? out.telemetry.torque_regenerating : out.telemetry.torque_motoring, T(150));
    this->receive(sign * T(100), true);
    out = this->run(35 * ms);
    EXPECT_EQ(out.telemetry.state, DriveState::torque) << "it has had its time";
    EXPECT_EQ(out.telemetry.torque_reached, out.telemetry.torque_reference);
    EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::none);
    this->receive(sign * T(-100), true);
    ASSERT_NE(this->run(3 * ms).telemetry.torque_reached, sign * T(-100));
    this->measurement.u_dc = T(2000);
    out = this->step();
    EXPECT_EQ(out.telemetry.state, DriveState::fault);
    EXPECT_EQ(out.telemetry.torque_reached, T(0)) << "no torque is held any more";
    this->measurement.u_dc = T(530);
  }
}

// A direct current brakes the turning rotor with more than the command, as regenerated torque does where the
// link falls at base speed.
TYPED_TEST(DriveOf, ATorqueThatTheVoltageHoldsBeyondItsReferenceIsDerated) {
  using T = TypeParam;
  for (const T sign : {T(1), T(-1)}) {
    for (const T rest : {T(-20), T(0)}) {
      SCOPED_TRACE(testing::Message() << sign << ", " << rest);
      auto parameters = slow_torque<T>();
      parameters.protection.current_jump = T(1e6);
      this->restart(parameters);
      this->measurement.i_abc = {T(40), T(-20), T(-20)};
      this->measurement.omega_m = sign * T(10);
      this->measurement.u_dc = T(530);
      this->measurement.applied = GatePattern{switch_states[0], period_ns};
      this->start(sign * T(-100));
      for (int k = 0; k < 10; ++k) {
        this->receive(sign * T(-100), true);
        this->run(35 * ms);
      }
      ASSERT_EQ(this->drive->state(), DriveState::torque);
      this->measurement.u_dc = T(60);
      this->receive(sign * rest, true);
      const auto out = this->run(2 * ms);
      EXPECT_EQ(out.telemetry.torque_reference, sign * rest);
      EXPECT_LT(sign * out.telemetry.torque_reached, rest - T(10));
      EXPECT_GT(sign * out.telemetry.torque_reached, T(-100));
      EXPECT_EQ(out.telemetry.state, DriveState::derated);
      EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::voltage_limit);
      EXPECT_GT(out.telemetry.torque_regenerating, -rest) << "more is available than is asked";
    }
  }
}

// No current flows, so that the machine makes no torque.
TYPED_TEST(DriveOf, TorqueThatDoesNotFollowTheCommandIsAFaultThatIsLeftByResetDisableEnable) {
  using T = TypeParam;
  this->measurement.i_abc = {};
  this->measurement.applied = GatePattern{switch_states[0], period_ns};
  this->start(T(9));
  EXPECT_EQ(this->run(50 * ms).telemetry.state, DriveState::torque) << "just inside";
  this->receive(T(11), true);
  const std::int64_t begin_ns = this->t_ns;
  while (this->step().telemetry.state == DriveState::torque && this->t_ns < begin_ns + 20 * ms) {
  }
  EXPECT_LE(this->t_ns - begin_ns, 10 * ms + period_ns);
  EXPECT_GE(this->t_ns - begin_ns, 8 * ms);
  auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::fault) << "latched";
  EXPECT_EQ(out.telemetry.first_fault, Fault::torque_plausibility);
  EXPECT_FALSE(out.telemetry.active.any());
  this->receive(T(0), false, true);
  EXPECT_EQ(this->step().telemetry.state, DriveState::standby);
  this->receive(T(0), false);
  EXPECT_EQ(this->step().telemetry.state, DriveState::ready);
  this->receive(T(9), true);
  EXPECT_EQ(this->run(30 * ms).telemetry.state, DriveState::torque);
}

TYPED_TEST(DriveOf, AMeasurementThatIsNoNumberDoesNotStayInTheTorqueMonitor) {
  using T = TypeParam;
  this->measurement.applied = GatePattern{switch_states[0], period_ns};
  this->start(T(5));
  this->measurement.i_abc.b = this->nan;
  this->step();
  this->measurement.i_abc.b = T(-2);
  this->receive(T(0), false, true);
  this->step();
  this->start(T(5));
  EXPECT_TRUE(std::isfinite(this->run(2 * ms).telemetry.torque_monitored));
  EXPECT_EQ(this->drive->state(), DriveState::torque);
}

// A blocked request must not lend its sign to the setpoint that is held.
TYPED_TEST(DriveOf, ABlockedBrakingRequestDoesNotLiftTheLimitOfTheTorqueThatIsHeld) {
  using T = TypeParam;
  this->start(T(100));
  this->measurement.omega_m = T(250);
  const T limited = this->run(ms).telemetry.torque_reference;
  ASSERT_LT(limited, T(65));
  this->receive(T(-400), true);
  const auto out = this->run(ms);
  EXPECT_EQ(out.telemetry.state, DriveState::derated);
  EXPECT_EQ(out.telemetry.torque_reference, limited);
  EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::voltage_limit) << "that of the setpoint";
}

TYPED_TEST(DriveOf, TheReferenceIsZeroInThePeriodInWhichMagnetisingBegins) {
  using T = TypeParam;
  typename Drive<T>::Parameters parameters;
  this->restart(parameters);
  this->controller->estimate().magnetised = false;
  this->measurement.omega_m = T(0);
  this->step();
  this->receive(T(0), false);
  this->run(ms);
  this->receive(T(15), true);
  DriveOutput<T> out;
  do {
    out = this->step();
    EXPECT_EQ(out.telemetry.torque_reference, T(0)) << to_string(out.telemetry.state);
  } while (out.telemetry.state != DriveState::magnetising && !this->HasFailure());
  EXPECT_EQ(this->controller->last_reference.torque, T(0));
  // Were something left of it, it would come with the first torque.
  this->controller->estimate().magnetised = true;
  EXPECT_EQ(this->step().telemetry.torque_reference, T(0));
}

TYPED_TEST(DriveOf, TheLinkCurrentDoesNotInheritAMeasurementThatIsNoNumber) {
  using T = TypeParam;
  this->measurement.applied = GatePattern{switch_states[1], period_ns};
  EXPECT_TRUE(std::isfinite(this->step().telemetry.i_dc));
  const ThreePhase<T> good = this->measurement.i_abc;
  this->measurement.i_abc.a = this->nan;
  this->step();
  this->measurement.i_abc = good;
  EXPECT_EQ(this->step().telemetry.i_dc, good.a);
}

// Five milliseconds of which one period was driven: what flowed before died right after it.
TYPED_TEST(DriveOf, TheLinkCurrentOfAGapIsNotThatOfTheCurrentsBeforeIt) {
  using T = TypeParam;
  this->measurement.i_abc = {T(40), T(-20), T(-20)};
  this->measurement.applied = GatePattern{switch_states[1], period_ns};
  EXPECT_NEAR(this->step().telemetry.i_dc, T(20), T(1e-4));  // mean of nothing and 40 A
  this->measurement.i_abc = {};
  this->measurement.applied.append({gates_off, 199 * period_ns});
  EXPECT_NEAR(this->step().telemetry.i_dc, T(40) / T(200), T(1e-4));
}

TYPED_TEST(DriveOf, TelemetrySaysWhatWasMeasuredEstimatedAndAsked) {
  using T = TypeParam;
  this->start(T(15));
  this->controller->estimate() = {{T(1), T(0.5)}, T(1.118), T(14.5), T(0), 2, true, T(0.5), T(0.9), T(0.07)};
  this->request.command.counter = 7;
  this->request.command.rejected = 3;
  this->measurement.applied = GatePattern{switch_states[1], 25'000};
  const std::int64_t now_ns = this->t_ns;
  const Telemetry<T> x = this->step().telemetry;
  EXPECT_EQ(x.t_ns, now_ns);
  EXPECT_EQ(x.torque_requested, T(15));
  EXPECT_EQ(x.torque_reference, T(15));
  EXPECT_EQ(x.torque, T(14.5));
  EXPECT_EQ(x.psi_s, (SpaceVector<T>{T(1), T(0.5)}));
  EXPECT_EQ(x.psi_s_magnitude, T(1.118));
  EXPECT_EQ(x.r_s, T(0.5));
  EXPECT_EQ(x.r_r, T(0.9));
  EXPECT_EQ(x.l_m, T(0.07));
  EXPECT_EQ(x.i_abc, this->measurement.i_abc);
  EXPECT_EQ(x.i_dc, T(5));  // V1 applied: leg a alone was high
  EXPECT_EQ(x.u_dc, T(530));
  EXPECT_EQ(x.omega_m, T(10));
  EXPECT_EQ(x.sector, 2);
  EXPECT_EQ(x.pattern.last_state(), switch_states[1]);
  EXPECT_EQ(x.command_counter, 7);
  EXPECT_EQ(x.command_rejected, 3U);
  EXPECT_EQ(x.command_sequence, this->request.command.sequence);
  EXPECT_EQ(x.command_received_ns, this->request.command.received_ns);
}

// The invariants in step() hold whatever comes: commands, silence, faults, resets and NaN at random.
TYPED_TEST(DriveOf, TheGatesObeyLockoutAndFaultsUnderRandomInput) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_int_distribution<int> dice{0, 999};
  const Measurement<T> good = this->measurement;
  int periods_on = 0;
  for (int k = 0; k < 100'000; ++k) {
    this->measurement = good;
    this->request.external = {};
    const int event = dice(random);
    if (event < 20) this->receive(T(0.35) * T(dice(random)) - T(175), dice(random) < 700, dice(random) < 200);
    if (event == 20) this->measurement.i_abc.a = this->nan;
    if (event == 21) this->measurement.u_dc = T(900);
    if (event == 22) this->request.external.set(Fault::overrun);
    if (event == 23) this->request.command.e2e = E2eState::invalid;
    if (event == 24) this->t_ns += 60 * ms;
    if (event == 25) this->request.command.bus_off = true;
    if (event > 25 && event < 50) this->request.command.bus_off = false;
    const auto out = this->step();
    periods_on += gates_are_on(out.telemetry.state) ? 1 : 0;
    ASSERT_TRUE(std::isfinite(out.telemetry.torque_reference));
    ASSERT_LE(std::abs(out.telemetry.torque_reference), T(150));
    if (this->HasFailure()) return;
  }
  EXPECT_GT(periods_on, 1000);
}

/// A controller that was built for these times.
template <class T>
class TimedController final : public Controller<T> {
 public:
  explicit TimedController(ControlTiming timing) : timing_{timing} {}
  [[nodiscard]] GatePattern step(const Measurement<T>& /*measurement*/,
                                 ControlReference<T> reference) noexcept override {
    const bool on = reference.mode != ControlMode::off;
    return GatePattern{on ? switch_states[1] : gates_off, timing_.period_ns};
  }
  void reset() noexcept override {}
  [[nodiscard]] ControlTiming timing() const noexcept override { return timing_; }

 private:
  ControlTiming timing_;
};

TYPED_TEST(DriveOf, RefusesAControllerOfAnotherPeriodOrSamplingInstant) {
  using T = TypeParam;
  typename TestFixture::DriveParameters parameters;
  parameters.sampling_lead_ns = 12'500;
  const auto problem = [&](ControlTiming timing) { return parameters.validate(TimedController<T>{timing}); };
  EXPECT_EQ(problem({25'000, 12'500}), nullptr);
  EXPECT_STREQ(problem({50'000, 12'500}), "the control periods of drive and controller differ");
  EXPECT_STREQ(problem({25'000, 0}), "the sampling instants of drive and controller differ");
  EXPECT_EQ(problem({}), nullptr) << "one that does not tell";
  parameters.motor.capability.voltage_use = T(1.05);
  EXPECT_STREQ(problem({}), "the controller does not reach the share of voltage, which is above 1");
  typename FieldOrientedController<T>::Parameters six_step;
  six_step.modulator.overmodulation = Overmodulation::fundamental;
  parameters.sampling_lead_ns = 0;
  EXPECT_EQ(parameters.validate(FieldOrientedController<T>{six_step}), nullptr);
  parameters.period_ns = 0;
  EXPECT_NE(problem({0, 12'500}), nullptr) << "the parameters themselves";
}

// With the gates off its length does not matter. A controller that is mended is enabled as after each fault.
TYPED_TEST(DriveOf, APatternThatDoesNotFillTheControlPeriodIsAFaultInThatPeriodAndNeverApplied) {
  using T = TypeParam;
  for (const bool magnetise_first : {false, true}) {
    for (const std::int32_t other_ns : {0, 12'500, 50'000}) {
      SCOPED_TRACE(testing::Message() << magnetise_first << ", " << other_ns << " ns");
      this->restart({.magnetise_first = magnetise_first});
      this->controller->estimate().magnetised = !magnetise_first;
      this->controller->pattern_ns = other_ns;
      this->step();
      this->receive(T(0), false);
      EXPECT_EQ(this->run(ms).telemetry.state, DriveState::ready);
      this->receive(T(15), true);
      const DriveOutput<T> out = this->step();
      EXPECT_EQ(out.pattern, (GatePattern{gates_off, period_ns}));
      EXPECT_EQ(out.telemetry.pattern, out.pattern);
      EXPECT_EQ(out.telemetry.state, DriveState::fault);
      EXPECT_TRUE(out.telemetry.active.test(Fault::torque_plausibility));
      EXPECT_EQ(out.telemetry.first_fault, Fault::torque_plausibility);
      EXPECT_EQ(out.telemetry.fault_total, 1U);
      EXPECT_EQ(out.telemetry.torque_reference, T(0));
      EXPECT_EQ(out.telemetry.derating_cause, DeratingCause::gates_are_off);
      EXPECT_EQ(this->run(ms).telemetry.state, DriveState::fault) << "latched";
      this->controller->pattern_ns = period_ns;
      this->controller->estimate().magnetised = true;
      this->receive(T(0), false, true);
      EXPECT_EQ(this->step().telemetry.state, DriveState::standby);
      this->receive(T(0), false);
      EXPECT_EQ(this->step().telemetry.state, DriveState::ready);
      this->receive(T(15), true);
      EXPECT_EQ(this->step().telemetry.state, DriveState::torque);
    }
  }
}

TYPED_TEST(DriveOf, RefusesParametersThatCannotWork) {
  using Parameters = typename TestFixture::DriveParameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  Parameters parameters;
  parameters.period_ns = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.magnetise_timeout_ns = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.command.blocked_limit = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.protection.over_current = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.motor.capability.torque = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.motor.optimal_flux.least_share = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.torque_monitor.limit = 0;
  EXPECT_NE(parameters.validate(), nullptr);
  parameters = {};
  parameters.period_ns = 50'000;  // and the protections count 25 us
  EXPECT_NE(parameters.validate(), nullptr);
  parameters.protection.period_ns = 50'000;
  EXPECT_EQ(parameters.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
