// The whole drive on a plant whose inverter has dead time or drops: what it knows of it, and what it then
// does.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/control/controller_list.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

constexpr std::int32_t dead_ns = 1'500;

using Foc = FieldOrientedController<double>;
using Dtc = DirectTorqueController<double>;

/// What the inverter has, and what the drive is told of it.
struct Inverters {
  InverterModel<>::Parameters has{};
  InverterModel<>::Parameters known{};
};

RigParameters rig_of(double omega_m, const Inverters& inverter) {
  const InverterModel<>::Parameters& known = inverter.known;
  RigParameters p = RigParameters::at_speed(omega_m);
  p.stage.io.dead_time_ns = inverter.has.dead_time_ns;
  p.stage.io.minimum_pulse = inverter.has.minimum_pulse;
  p.stage.plant.drops = {.threshold_voltage = inverter.has.threshold_voltage,
                         .slope_resistance = inverter.has.slope_resistance};
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  p.controller.inverter = known;
  p.drive.magnetise_first = true;
  p.drive.protection.inverter = known;
  p.drive.torque_monitor.inverter = known;
  return p;
}

template <class C>
typename C::Parameters method_of(const RigParameters& p) {
  typename C::Parameters c;
  static_cast<EstimatingController<double>::Parameters&>(c) = p.controller;
  return c;
}

struct Seen {
  double idle_current{};  ///< peak before any torque is commanded [A]
  double torque{};        ///< mean [N·m]
  bool tripped{};
  std::int64_t short_pulses{};  ///< commanded, where there is a minimum pulse
};

template <class C>
Seen run(double omega_m, double torque, const Inverters& inverter) {
  const RigParameters p = rig_of(omega_m, inverter);
  DriveRigOf<C> rig{p, method_of<C>(p)};
  rig.start();
  Seen seen;
  seen.idle_current = rig.watch(0.4).peak_current;
  rig.torque = torque;
  rig.run(0.3);
  seen.torque = rig.watch(0.1).mean_torque;
  seen.tripped = rig.telemetry.latched.any();
  seen.short_pulses = rig.io().short_pulses().value_or(0);
  return seen;
}

template <class C>
class InverterRunOf : public testing::Test {};
using Methods = testing::Types<Foc, Dtc>;
TYPED_TEST_SUITE(InverterRunOf, Methods);

/// A drive that is told what the inverter has makes its torque.
template <class C>
void expect_torque(const InverterModel<>::Parameters& inverter) {
  for (const double omega_m : {-200.0, 0.0, 5.0, 20.0}) {
    for (const double torque : {-60.0, 15.0}) {
      SCOPED_TRACE(testing::Message() << omega_m << " rad/s, " << torque << " N·m");
      const Seen seen = run<C>(omega_m, torque, {inverter, inverter});
      EXPECT_FALSE(seen.tripped);
      EXPECT_NEAR(seen.torque, torque, 4.0);
      // That of magnetising, and the torque ripple's at zero torque.
      EXPECT_LT(seen.idle_current, 1.1 * 40.0);
    }
  }
}

TYPED_TEST(InverterRunOf, ADriveThatKnowsTheDeadTimeMakesTheTorque) {
  expect_torque<TypeParam>({.dead_time_ns = dead_ns});
}

TYPED_TEST(InverterRunOf, ADriveThatKnowsTheDropsMakesTheTorque) {
  expect_torque<TypeParam>({.threshold_voltage = 1.2, .slope_resistance = 0.02});
}

template <class C>
class MinimumPulseRunOf : public testing::Test {};
template <class List>
struct TypesOf;
template <class... C>
struct TypesOf<std::tuple<C...>> {
  using Type = testing::Types<C...>;
};
using EveryMethod = TypesOf<ControllerList<double>>::Type;
TYPED_TEST_SUITE(MinimumPulseRunOf, EveryMethod);

// The voltage suffices up to 139 rad/s, near which a leg is low for a short time only.
TYPED_TEST(MinimumPulseRunOf, ADriveThatKnowsItCommandsNoShorterPulseAndMakesTheTorque) {
  for (const ShortPulses kind : {ShortPulses::dropped, ShortPulses::stretched}) {
    const InverterModel<>::Parameters inverter{.dead_time_ns = 500, .minimum_pulse = {1'000, kind}};
    for (const auto& [omega_m, torque] :
         {std::pair{0.0, 15.0}, {20.0, -15.0}, {135.0, 15.0}, {-135.0, 15.0}}) {
      SCOPED_TRACE(testing::Message() << omega_m << " rad/s, " << torque << " N·m, kind " << int(kind));
      const Seen seen = run<TypeParam>(omega_m, torque, {inverter, inverter});
      EXPECT_FALSE(seen.tripped);
      EXPECT_NEAR(seen.torque, torque, 4.0);
      EXPECT_LT(seen.idle_current, 1.1 * 40.0);
      EXPECT_EQ(seen.short_pulses, 0);
    }
  }
}

// The same run would otherwise show nothing.
TEST(InverterRun, ADriveThatDoesNotKnowItCommandsShorterPulses) {
  const InverterModel<>::Parameters inverter{.minimum_pulse = {1'000, ShortPulses::dropped}};
  EXPECT_GT(run<Foc>(135.0, 15.0, {inverter, {}}).short_pulses, 1'000);
}

// Of 40 V a tenth remains, which is the resistive voltage of 10 A, or the EMF at 2 rad/s.
TYPED_TEST(InverterRunOf, ADriveThatIsToldADeadTimeOfATenthMoreOrLessMakesTheTorque) {
  for (const std::int32_t told_ns : {1'350, 1'650}) {
    InverterModel<>::Parameters told{.dead_time_ns = told_ns};
    told.voltage_error = told.likely_voltage_error(25'000, 530.0);
    for (const double omega_m : {-20.0, 0.0, 5.0}) {
      for (const double torque : {-90.0, 60.0}) {
        SCOPED_TRACE(testing::Message() << told_ns << " ns, " << omega_m << " rad/s, " << torque << " N·m");
        const Seen seen = run<TypeParam>(omega_m, torque, {{.dead_time_ns = dead_ns}, told});
        EXPECT_FALSE(seen.tripped);
        EXPECT_NEAR(seen.torque, torque, std::max(5.5, 0.075 * std::abs(torque)));
        EXPECT_LT(seen.idle_current, 1.1 * 40.0);
      }
    }
  }
}

// Without torque the machine that does not saturate at weakened flux takes some 2 A, and near standstill dead
// times stop the currents: there readings with their offsets have other signs than the currents.
TEST(InverterRun, OffsetsOfSmallCurrentsAreNoFault) {
  const InverterModel<>::Parameters known{
      .dead_time_ns = dead_ns,
      .voltage_error =
          InverterModel<>::Parameters{.dead_time_ns = dead_ns}.likely_voltage_error(25'000, 530.0)};
  for (const double omega_m : {-400.0, -300.0, -5.0, 5.0, 300.0, 400.0}) {
    SCOPED_TRACE(testing::Message() << omega_m << " rad/s");
    RigParameters p = rig_of(omega_m, {{.dead_time_ns = dead_ns}, known});
    p.stage.plant.saturation = {.knee = 1.1, .machine_flux = 1.1};
    p.stage.io.sensors.current = {.noise = 0.2, .range = 300.0, .bits = 12};
    p.stage.io.sensors.phases = {PhaseSensorError{0.02, 0.5}, PhaseSensorError{-0.02, -0.5}};
    p.drive.protection.current_noise = 0.25;
    p.drive.protection.current_step = 0.75;
    p.controller.magnetiser.current_limit = 25.0;
    DriveRigOf<Foc> rig{p, method_of<Foc>(p)};
    rig.run(0.05);
    rig.start();
    rig.run(0.6);
    EXPECT_TRUE(makes_torque(rig.drive().state()));
    EXPECT_EQ(rig.telemetry.latched, FaultSet{});
  }
}

}  // namespace
}  // namespace sextant
