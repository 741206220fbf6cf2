#include "sextant/drive/motor_control.hpp"

#include <gtest/gtest.h>

#include "sextant/drive/drive.hpp"
#include "sextant/drive/induction_motor.hpp"

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int32_t period_ns = 25'000;

/// A motor that is no induction machine: it makes what is demanded, and keeps what it was asked.
template <class T>
class RecordingMotor {
 public:
  struct Parameters {
    T torque{T(100)};  ///< available [N·m]

    [[nodiscard]] const char* validate(const ControlTiming& timing) const noexcept {
      return timing.period_ns == period_ns ? nullptr : "the motor knows one period";
    }
    [[nodiscard]] T inertia() const noexcept { return T(0.1); }
  };

  RecordingMotor(const Parameters& p, const ControlTiming& /*timing*/) noexcept : parameters_{p} {
    estimate_.magnetised = true;
  }

  [[nodiscard]] AvailableTorque<T> available(const Measurement<T>& /*measurement*/, T /*dt*/) noexcept {
    const LimitedTorque<T> limit{parameters_.torque, DeratingCause::none};
    return {limit, limit};
  }
  [[nodiscard]] LimitedTorque<T> present_limit(T /*enough*/) const noexcept { return present; }
  [[nodiscard]] GatePattern step(const Measurement<T>& measurement, const MotorDemand<T>& wanted,
                                 T /*dt*/) noexcept {
    demand = wanted;
    seen = measurement;
    reference_ = {wanted.mode, wanted.torque, T(1)};
    estimate_.torque = wanted.torque;
    return GatePattern{wanted.mode == ControlMode::off ? gates_off : switch_states[1], pattern_ns};
  }
  void discard_pattern() noexcept { reference_ = {}; }
  void restart() noexcept { ++restarts; }
  [[nodiscard]] bool takes_parameters() const noexcept { return true; }
  void take_parameters(const RecordingMotor& from) noexcept { parameters_ = from.parameters_; }
  [[nodiscard]] const ControlEstimate<T>& estimate() const noexcept { return estimate_; }
  [[nodiscard]] const ControlReference<T>& reference() const noexcept { return reference_; }
  [[nodiscard]] T flux_reference() const noexcept { return T(0); }

  static inline std::int32_t pattern_ns{period_ns};
  static inline LimitedTorque<T> present{};
  static inline MotorDemand<T> demand{};
  static inline Measurement<T> seen{};
  static inline int restarts{0};

 private:
  Parameters parameters_;
  ControlEstimate<T> estimate_{};
  ControlReference<T> reference_{};
};

template <class T>
class DriveOfAnyMotor : public testing::Test {
 protected:
  using Motor = RecordingMotor<T>;
  using Parameters = typename Drive<T, Motor>::Parameters;

  static constexpr ThreePhase<T> currents{T(5), T(-2), T(-3)};  // [A]

  static Parameters parameters() {
    Parameters p;
    p.torque_monitor.enabled = false;
    return p;
  }

  DriveOfAnyMotor() {
    Motor::pattern_ns = period_ns;
    Motor::present = {};
    Motor::restarts = 0;
    measurement.u_dc = T(530);
    measurement.omega_m = T(10);
    measurement.i_abc = currents;
  }

  DriveOutput<T> run(int periods) {
    DriveOutput<T> output;
    for (int k = 0; k < periods; ++k) {
      output = drive.step(t_ns, measurement, request);
      t_ns += period_ns;
    }
    return output;
  }

  DriveOutput<T> command(T torque, bool enable, bool fault_reset = false) {
    request.command.torque = torque;
    request.command.torque_limit = T(150);
    request.command.enable = enable;
    request.command.fault_reset = fault_reset;
    request.command.received_ns = t_ns;
    request.command.e2e = E2eState::valid;
    ++request.command.sequence;
    return run(40);
  }

  void start(T torque) {
    command(T(0), false);
    ASSERT_EQ(command(torque, true).telemetry.state, DriveState::torque);
  }

  Drive<T, Motor> drive{parameters()};
  std::int64_t t_ns{5 * ms};
  Measurement<T> measurement{};
  DriveRequest<T> request{};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DriveOfAnyMotor, Scalars);

static_assert(!MotorControl<TorqueCapability<double>, double>);
static_assert(MotorControl<InductionMotor<double>, double> && MotorControl<InductionMotor<float>, float>);

TYPED_TEST(DriveOfAnyMotor, ItsMotorGetsTheCommandedTorqueWithinWhatItAllows) {
  using T = TypeParam;
  using Recorder = RecordingMotor<T>;
  this->start(T(15));
  EXPECT_EQ(Recorder::demand.mode, ControlMode::torque);
  EXPECT_EQ(Recorder::demand.torque, T(15));
  EXPECT_EQ(Recorder::demand.steady_torque, T(15));
  EXPECT_FALSE(Recorder::demand.limited);
  const auto beyond = this->command(T(120), true);
  EXPECT_EQ(beyond.telemetry.state, DriveState::derated);
  EXPECT_EQ(Recorder::demand.torque, T(100));
  EXPECT_TRUE(Recorder::demand.limited);
  Recorder::present = {T(40), DeratingCause::current_limit};
  const auto held = this->command(T(120), true);
  EXPECT_EQ(Recorder::demand.torque, T(40));
  EXPECT_TRUE(Recorder::demand.at_present_limit);
  EXPECT_EQ(held.telemetry.derating_cause, DeratingCause::current_limit);
}

TYPED_TEST(DriveOfAnyMotor, ItsMotorTakesTheParametersOfAnotherOneUnderTorque) {
  using T = TypeParam;
  using Recorder = RecordingMotor<T>;
  this->start(T(90));
  typename TestFixture::Parameters lower = this->parameters();
  lower.motor.torque = T(60);
  const Drive<T, Recorder> other{lower};
  ASSERT_TRUE(this->drive.takes_parameters());
  this->drive.take_parameters(other);
  EXPECT_EQ(this->run(1).telemetry.state, DriveState::derated);
  EXPECT_EQ(Recorder::demand.torque, T(60));
}

TYPED_TEST(DriveOfAnyMotor, ATripTurnsItOffAndAResetRestartsIt) {
  using T = TypeParam;
  using Recorder = RecordingMotor<T>;
  this->start(T(15));
  this->measurement.i_abc = {T(201), T(-100), T(-101)};
  const auto tripped = this->run(1);
  EXPECT_EQ(tripped.telemetry.state, DriveState::fault);
  EXPECT_TRUE(tripped.telemetry.latched.test(Fault::over_current));
  EXPECT_EQ(tripped.pattern.last_state(), gates_off);
  EXPECT_EQ(Recorder::demand.mode, ControlMode::off);
  EXPECT_EQ(Recorder::demand.torque, T(0));
  EXPECT_EQ(Recorder::seen.i_abc.a, T(0)) << "a reading that tripped reached the motor's control";
  this->measurement.i_abc = this->currents;
  this->command(T(0), false);
  EXPECT_EQ(Recorder::restarts, 0);
  this->command(T(0), false, true);
  EXPECT_EQ(Recorder::restarts, 1);
}

TYPED_TEST(DriveOfAnyMotor, APatternThatDoesNotFillThePeriodIsAFault) {
  using T = TypeParam;
  using Recorder = RecordingMotor<T>;
  this->start(T(15));
  Recorder::pattern_ns = period_ns - 1;
  const auto output = this->run(1);
  EXPECT_EQ(output.telemetry.state, DriveState::fault);
  EXPECT_TRUE(output.telemetry.latched.test(Fault::torque_plausibility));
  EXPECT_EQ(output.pattern.last_state(), gates_off);
  EXPECT_EQ(output.pattern.duration_ns(), period_ns);
  EXPECT_EQ(output.telemetry.torque_reference, T(0));
}

TEST(DriveOfAMotor, RefusesWhatItsMotorRefuses) {
  Drive<double, RecordingMotor<double>>::Parameters p;
  EXPECT_EQ(p.validate(), nullptr);
  p.period_ns = p.protection.period_ns = 50'000;
  EXPECT_STREQ(p.validate(), "the motor knows one period");
}

}  // namespace
}  // namespace sextant
