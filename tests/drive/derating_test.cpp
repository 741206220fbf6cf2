// What takes torque away beside machine and link: the side that it limits, and the cause that is named.
#include <cmath>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "drive/fake_controller.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/drive/resolved.hpp"

namespace sextant {
namespace {

template <class T>
class DeratingOf : public testing::Test {
 protected:
  using Parameters = typename Drive<T>::Parameters;

  DeratingOf() {
    measurement.u_dc = T(530);
    measurement.omega_m = T(10);
    parameters.low_voltage = {T(500), T(300)};
    parameters.high_voltage = {T(600), T(660)};
  }

  /// A drive that has got this command [N·m] at this link voltage [V] for 50 ms.
  Telemetry<T> commanded(T torque, T u_dc) {
    controller.emplace();
    controller->estimate().psi_s = {T(1.1), T(0)};
    drive.emplace(parameters, *controller);
    std::int64_t t_ns = 5'000'000;
    Telemetry<T> last;
    DriveRequest<T> request;
    measurement.u_dc = u_dc;
    for (int k = 0; k < 2000; ++k, t_ns += 25'000) {
      request.command = {.torque = torque,
                         .torque_limit = T(150),
                         .enable = k > 10,
                         .received_ns = t_ns,
                         .sequence = std::uint64_t(k + 1),
                         .e2e = E2eState::valid};
      // The torque is what is asked for, so that nothing lags.
      controller->estimate().torque = controller->last_reference.torque;
      last = drive->step(t_ns, measurement, request).telemetry;
    }
    return last;
  }

  Parameters parameters{};
  std::optional<test::FakeController<T>> controller{};
  std::optional<Drive<T>> drive{};
  Measurement<T> measurement{};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DeratingOf, Scalars);

TYPED_TEST(DeratingOf, TheLinkVoltageLimitsTheSideThatMakesItWorse) {
  using T = TypeParam;
  const Telemetry<T> whole = this->commanded(T(15), T(530));
  EXPECT_EQ(whole.derating_cause, DeratingCause::none);
  EXPECT_EQ(whole.winding_temperature, std::nullopt) << "neither measured nor by a model";
  EXPECT_EQ(whole.torque_motoring, T(150));
  EXPECT_EQ(whole.torque_regenerating, T(150));
  const Telemetry<T> low = this->commanded(T(15), T(400));
  EXPECT_NEAR(low.torque_motoring, 75, 0.1);
  EXPECT_EQ(low.torque_regenerating, T(150));
  EXPECT_EQ(low.derating_cause, DeratingCause::dc_link_low);
  EXPECT_EQ(this->commanded(T(-15), T(400)).derating_cause, DeratingCause::none) << "the other side";
  const Telemetry<T> high = this->commanded(T(-15), T(640));
  EXPECT_EQ(high.torque_motoring, T(150));
  EXPECT_NEAR(high.torque_regenerating, 50, 0.1);
  EXPECT_EQ(high.derating_cause, DeratingCause::dc_link_high);
  EXPECT_EQ(this->commanded(T(15), T(640)).derating_cause, DeratingCause::none) << "the other side";
}

TYPED_TEST(DeratingOf, WithoutBandsTheLinkVoltageTakesNothing) {
  using T = TypeParam;
  this->parameters = {};
  for (const T u_dc : {T(300), T(690)}) {
    const Telemetry<T> t = this->commanded(T(15), u_dc);
    EXPECT_EQ(t.torque_motoring, T(150));
    EXPECT_EQ(t.torque_regenerating, T(150));
    EXPECT_EQ(t.derating_cause, DeratingCause::none);
  }
}

TYPED_TEST(DeratingOf, ATorqueBeyondWhatIsLeftIsLimitedAndDerated) {
  using T = TypeParam;
  const Telemetry<T> t = this->commanded(T(100), T(360));
  EXPECT_NEAR(t.torque_reference, 45, 0.1);
  EXPECT_EQ(t.state, DriveState::derated);
  EXPECT_EQ(t.derating_cause, DeratingCause::dc_link_low);
}

// Below its level the drive waits, and says for what; an enable that stands is taken up once the link is
// charged. With the gates on the level has no effect.
TYPED_TEST(DeratingOf, ALinkThatIsNotChargedKeepsTheDriveInStandby) {
  using T = TypeParam;
  this->parameters = {};
  this->parameters.ready_voltage = T(500);
  const Telemetry<T> waits = this->commanded(T(15), T(499));
  EXPECT_EQ(waits.state, DriveState::standby);
  EXPECT_EQ(waits.derating_cause, DeratingCause::dc_link_low);
  EXPECT_FALSE(waits.lockout);
  EXPECT_FALSE(waits.latched.any());
  std::int64_t t_ns = 5'000'000 + 2000 * 25'000;
  DriveRequest<T> request;
  std::uint64_t sequence = 3000;
  const auto step = [&](T u_dc) {
    this->measurement.u_dc = u_dc;
    request.command = {.torque = T(15),
                       .torque_limit = T(150),
                       .enable = true,
                       .received_ns = t_ns,
                       .sequence = ++sequence,
                       .e2e = E2eState::valid};
    const Telemetry<T> t = this->drive->step(t_ns, this->measurement, request).telemetry;
    t_ns += 25'000;
    return t;
  };
  EXPECT_EQ(step(T(500)).state, DriveState::ready);
  EXPECT_EQ(step(T(499)).state, DriveState::standby);
  EXPECT_EQ(step(T(501)).derating_cause, DeratingCause::gates_are_off);
  EXPECT_TRUE(gates_are_on(step(T(501)).state));
  EXPECT_TRUE(gates_are_on(step(T(400)).state));
  this->measurement.applied = GatePattern{SwitchState{LegState::low, LegState::low, LegState::low}, 25'000};
  const Telemetry<T> tripped = step(T(200));
  EXPECT_EQ(tripped.state, DriveState::fault);
  EXPECT_EQ(tripped.first_fault, Fault::dc_under_voltage);
  EXPECT_EQ(tripped.derating_cause, DeratingCause::gates_are_off);
}

// Two shares do not multiply: the smaller one suffices for both. 142.5 °C leaves a half.
TYPED_TEST(DeratingOf, OfWindingAndLinkTheOneThatLeavesLessCountsAndIsNamed) {
  using T = TypeParam;
  this->measurement.winding_temperature = T(142.5);
  const Telemetry<T> hot = this->commanded(T(15), T(480));
  EXPECT_NEAR(hot.torque_motoring, 75, 0.1);
  EXPECT_EQ(hot.derating_cause, DeratingCause::temperature);
  EXPECT_EQ(hot.winding_temperature, T(142.5));
  const Telemetry<T> low = this->commanded(T(15), T(340));
  EXPECT_NEAR(low.torque_motoring, 30, 0.1);
  EXPECT_NEAR(low.torque_regenerating, 75, 0.1);
  EXPECT_EQ(low.derating_cause, DeratingCause::dc_link_low);
}

TYPED_TEST(DeratingOf, TheControllerGetsTheTemperatureThatIsMeasuredOrElseModelled) {
  using T = TypeParam;
  (void)this->commanded(T(15), T(530));
  EXPECT_FALSE(this->controller->last_measurement.winding_temperature) << "neither";
  this->parameters.protection.winding = {.nominal_current = T(10), .ambient = T(33)};
  (void)this->commanded(T(15), T(530));
  EXPECT_EQ(this->controller->last_measurement.winding_temperature, T(33)) << "without current";
  this->measurement.winding_temperature = T(77);
  (void)this->commanded(T(15), T(530));
  EXPECT_EQ(this->controller->last_measurement.winding_temperature, T(77));
}

TYPED_TEST(DeratingOf, RefusesBandsBeyondTheTripLevelsOrTheWrongWayRound) {
  using T = TypeParam;
  using Bands = typename Drive<T>::Parameters;
  ASSERT_EQ(this->parameters.validate(), nullptr);
  const T nan = std::numeric_limits<T>::quiet_NaN();
  for (const auto& [full, zero] : {std::pair{T(400), T(260)}, {T(300), T(400)}, {nan, T(300)}}) {
    Bands p;
    p.low_voltage = {full, zero};
    EXPECT_NE(p.validate(), nullptr) << full << ", " << zero;
  }
  for (const auto& [full, zero] :
       {std::pair{T(600), T(701)}, {T(650), T(600)}, {T(600), nan}, {T(0), T(650)}}) {
    Bands p;
    p.high_voltage = {full, zero};
    EXPECT_NE(p.validate(), nullptr) << full << ", " << zero;
  }
}

// Three quarters of the way to the trip levels, 0.5 and 1.3 u_dc.
TYPED_TEST(DeratingOf, TheEndOfABandFollowsFromTheTripLevel) {
  using T = TypeParam;
  DriveSetup<T> setup;
  EXPECT_FALSE(resolved(setup).drive.low_voltage.acts());
  EXPECT_FALSE(resolved(setup).drive.high_voltage.acts());
  setup.capability.low_voltage = T(465);
  setup.capability.high_voltage = T(589);
  const typename Drive<T>::Parameters p = resolved(setup).drive;
  EXPECT_NEAR(p.low_voltage.zero, 265 + 50, 1e-3);
  EXPECT_NEAR(p.high_voltage.zero, 689 - 25, 1e-3);
  setup.capability.low_voltage_zero = T(400);
  EXPECT_EQ(resolved(setup).drive.low_voltage.zero, T(400));
  setup.capability.low_voltage = {};
  EXPECT_NE(resolved(setup).validate(), nullptr) << "the end of no band";
}

}  // namespace
}  // namespace sextant
