// A DC link whose voltage is a state, against closed forms, quadrature of the inverter's current, and energy.
#include "sextant/plant/dc_link.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Link = DcLink<double>;
using Meter = EnergyMeter<double>;
using Parameters = DcLinkParameters<>;
using Plant = DrivePlant<double, AppendedPair<Link, Meter>>;
using Stiff = DrivePlant<double, Meter>;

constexpr double u_0 = 530.0;

struct Named {
  std::string name;
  std::unique_ptr<PlantIntegrator<Plant>> integrator;
};

std::vector<Named> all_integrators() {
  std::vector<Named> all;
  CvodeParameters newton;
  newton.method = CvodeMethod::bdf_newton;
  all.push_back({"fixed", std::make_unique<FixedStepIntegrator<Plant>>()});
  all.push_back({"exact", std::make_unique<ExactIntegrator<Plant>>()});
  all.push_back({"erk", std::make_unique<ErkIntegrator<Plant>>()});
  all.push_back({"cvode", std::make_unique<CvodeIntegrator<Plant>>()});
  all.push_back({"cvode, Newton", std::make_unique<CvodeIntegrator<Plant>>(newton)});
  return all;
}

Plant plant_with(const Parameters& link, double voltage, const DrivePlantParameters<>& p = {}) {
  const Meter meter{};
  return Plant{p, {Link{link, p.machine.sigma_l_s(), voltage}, meter}};
}

const Link& link_of(const Plant& plant) {
  return std::as_const(plant).appended_system().first;
}

Link::Values states_of(const Plant& plant) {
  return Link::Values{plant.state().data() + Plant::appended, std::size_t(Link::size)};
}

/// A plant at rest without flux, whose gates are off: it takes no current from the link.
PlantInputs<> idle() {
  PlantInputs<> inputs{};
  inputs.u_dc = u_0;
  inputs.imposed_speed = true;
  return inputs;
}

/// Link voltage every 25 µs. [V]
std::vector<double> voltages(Plant plant, PlantIntegrator<Plant>& integrator, std::size_t periods) {
  std::vector<double> u;
  for (std::size_t n = 0; n < periods; ++n) {
    if (!integrator.advance(plant, switching_period_ns)) return {};
    u.push_back(plant.u_dc());
  }
  return u;
}

/// Of what expected(t) says, every 25 µs. [V]
template <class Expected>
double largest_error(const std::vector<double>& u, Expected expected) {
  double error = u.empty() ? std::numeric_limits<double>::infinity() : 0.0;
  for (std::size_t n = 0; n < u.size(); ++n)
    error = std::max(error, std::abs(u[n] - expected(1e-9 * double(switching_period_ns) * double(n + 1))));
  return error;
}

TEST(DcLink, ParametersAreChecked) {
  const auto problem = [](const Parameters& p) {
    return std::string{p.validate() == nullptr ? "" : p.validate()};
  };
  EXPECT_EQ(problem({}), "");
  EXPECT_EQ(problem({1e-3, 0.2}), "");
  EXPECT_EQ(problem({1e-3, 0.2, 1e-4, true, 20, 650, 620}), "");
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Parameters& p :
       {Parameters{-1e-3, 0.2}, Parameters{nan, 0.2}, Parameters{1e-3, -0.2}, Parameters{1e-3, 0.2, INFINITY},
        Parameters{1e-3, 0.2, 0, false, -20}, Parameters{1e-3, 0.2, 0, false, 20, nan, 620}})
    EXPECT_THAT(problem(p), HasSubstr("finite and not below zero"));
  EXPECT_THAT(problem({1e-3, 0}), HasSubstr("resistance of the source must be above zero"));
  for (const Parameters& p : {Parameters{0, 0.2}, Parameters{0, 0, 1e-4}, Parameters{0, 0, 0, true},
                              Parameters{0, 0, 0, false, 20, 650, 620}})
    EXPECT_THAT(problem(p), HasSubstr("need a DC link with a capacitance above zero"));
  for (const Parameters& p :
       {Parameters{1e-3, 0.2, 0, false, 20, 650, 650}, Parameters{1e-3, 0.2, 0, false, 20, 650, 0},
        Parameters{1e-3, 0.2, 0, false, 20}})
    EXPECT_THAT(problem(p), HasSubstr("below that at which it turns on"));
  EXPECT_THAT(problem({1e-3, 0.2, 0, false, 0, 650, 620}), HasSubstr("need a resistance of it above zero"));
  EXPECT_EQ(problem({1e-3, 0.2, 0, false, 0, 0, 0, 0.0, 50, 0.9}), "");
  EXPECT_THAT(problem({1e-3, 0.2, 0, false, 0, 0, 0, -1.0}), HasSubstr("finite and not below zero"));
  EXPECT_THAT(problem({1e-3, 0.2, 0, false, 0, 0, 0, {}, -50}), HasSubstr("finite and not below zero"));
  EXPECT_THAT(problem({0, 0, 0, false, 0, 0, 0, {}, 50}), HasSubstr("a pre-charge need a DC link"));
  EXPECT_THAT(problem({1e-3, 0.2, 0, false, 0, 0, 0, {}, 50, 1.0}), HasSubstr("between 0 and 1"));
  EXPECT_THAT(problem({1e-3, 0.2, 0, false, 0, 0, 0, {}, 0, 0.9}),
              HasSubstr("needs a pre-charge resistance"));
}

TEST(DcLink, ChargesThroughAResistanceAsTheExponential) {
  for (const Parameters& p : {Parameters{1e-3, 0.2}, Parameters{50e-6, 0.05}, Parameters{5e-3, 2.0}}) {
    for (const Named& each : all_integrators()) {
      SCOPED_TRACE(each.name);
      Plant plant = plant_with(p, 0.0);
      plant.set_inputs(idle());
      const double rc = p.source_resistance * p.capacitance;
      const auto u = voltages(plant, *each.integrator, 200);
      EXPECT_LT(largest_error(u, [&](double t) { return u_0 * -std::expm1(-t / rc); }), 1e-6 * u_0);
    }
  }
}

TEST(DcLink, ChargesThroughAnInductanceAsTheDampedOscillation) {
  for (const Parameters& p : {Parameters{1e-3, 0.2, 1e-3}, Parameters{50e-6, 0.05, 20e-6}}) {
    const double a = p.source_resistance / (2 * p.source_inductance);
    const double w = std::sqrt(1 / (p.source_inductance * p.capacitance) - a * a);
    for (const Named& each : all_integrators()) {
      SCOPED_TRACE(each.name);
      Plant plant = plant_with(p, 0.0);
      plant.set_inputs(idle());
      const auto u = voltages(plant, *each.integrator, 400);
      const auto expected = [&](double t) {
        return u_0 * (1 - std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t)));
      };
      EXPECT_LT(largest_error(u, expected), 1e-5 * u_0);
    }
  }
}

// A rectifier charges the capacitor over the first half wave to more than its voltage, and blocks.
TEST(DcLink, ADiodeHoldsThePeakOfTheOscillation) {
  const Parameters p{1e-3, 0.2, 1e-3, true};
  const double a = p.source_resistance / (2 * p.source_inductance);
  const double w = std::sqrt(1 / (p.source_inductance * p.capacitance) - a * a);
  const double peak = u_0 * (1 + std::exp(-a * std::numbers::pi / w));
  for (const Named& each : all_integrators()) {
    SCOPED_TRACE(each.name);
    Plant plant = plant_with(p, 0.0);
    plant.set_inputs(idle());
    for (int n = 0; n < 400; ++n) {
      ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
      EXPECT_GE(link_of(plant).current(states_of(plant), u_0), -Link::current_tolerance);
    }
    EXPECT_FALSE(link_of(plant).conducts());
    EXPECT_NEAR(plant.u_dc(), peak, 1e-5 * peak);
  }
}

// Without inductance the diode carries what the capacitor is short of, and nothing above the source.
TEST(DcLink, ADiodeKeepsWhatIsAboveTheSourceUntilTheSourceRises) {
  const Parameters p{1e-3, 0.2, 0, true};
  for (const Named& each : all_integrators()) {
    SCOPED_TRACE(each.name);
    Plant plant = plant_with(p, 600.0);
    PlantInputs<> inputs = idle();
    plant.set_inputs(inputs);
    for (int n = 0; n < 40; ++n) ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
    EXPECT_EQ(plant.u_dc(), 600.0);
    inputs.u_dc = 650.0;
    plant.set_inputs(inputs);
    const auto u = voltages(plant, *each.integrator, 40);
    EXPECT_LT(largest_error(u, [&](double t) { return 650 - 50 * std::exp(-t / 200e-6); }), 1e-4);
  }
}

TEST(DcLink, TheChopperDischargesFromItsUpperToItsLowerVoltage) {
  const Parameters p{1e-3, 0.2, 0, true, 20.0, 650.0, 610.0};
  const double off_s = p.chopper_resistance * p.capacitance * std::log(660.0 / 610.0);
  for (const Named& each : all_integrators()) {
    SCOPED_TRACE(each.name);
    Plant plant = plant_with(p, 649.9);
    plant.set_inputs(idle());
    ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
    EXPECT_FALSE(link_of(plant).chops());
    Plant::State x = plant.state();
    x[Plant::appended] = 660.0;
    plant.set_state(x);
    EXPECT_TRUE(link_of(plant).chops());
    const auto u = voltages(plant, *each.integrator, 100);
    EXPECT_LT(largest_error(u, [&](double t) { return std::max(610.0, 660 * std::exp(-t / 20e-3)); }), 1e-5);
    ASSERT_GT(100 * 25e-6, off_s);
  }
}

/// From an empty capacitor, by closed form: through R + R_p to the share of u_0, on through R.
double precharged(const Parameters& p, double t) {
  const double slow = (p.source_resistance + p.precharge_resistance) * p.capacitance;
  const double closes = -slow * std::log(1 - p.contactor_share);
  if (t < closes) return u_0 * -std::expm1(-t / slow);
  return u_0 *
         (1 - (1 - p.contactor_share) * std::exp(-(t - closes) / (p.source_resistance * p.capacitance)));
}

TEST(DcLink, APrechargeResistorChargesTheCapacitorUntilTheContactorCloses) {
  const Parameters p{100e-6, 0.5, 0, true, 0, 0, 0, 0.0, 5.0, 0.9};
  for (const Named& each : all_integrators()) {
    SCOPED_TRACE(each.name);
    Plant plant = plant_with(p, 0.0);
    plant.set_inputs(idle());
    const auto u = voltages(plant, *each.integrator, 200);
    EXPECT_LT(largest_error(u, [&](double t) { return precharged(p, t); }), 1e-6 * u_0);
  }
}

// Whatever the resistances are, they take as much as the capacitor gets, of which 1 % is still on its way.
TEST(DcLink, HalfOfWhatTheSourceDeliversChargesTheCapacitor) {
  for (const double inductance : {0.0, 20e-6}) {
    const Parameters p{100e-6, 0.5, inductance, false, 0, 0, 0, 0.0, 5.0, 0.9};
    for (const Named& each : all_integrators()) {
      SCOPED_TRACE(each.name + ", " + std::to_string(inductance) + " H");
      Plant plant = plant_with(p, 0.0);
      plant.set_inputs(idle());
      EXPECT_FALSE(link_of(plant).is_closed());
      for (int n = 0; n < 400; ++n) ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
      EXPECT_TRUE(link_of(plant).is_closed());
      const double half = 0.5 * p.capacitance * u_0 * u_0;
      EXPECT_NEAR(states_of(plant)[Link::resistance], half, 1e-5 * half);
      EXPECT_NEAR(states_of(plant)[Link::source], 2 * half, 1e-5 * half);
      EXPECT_NEAR(link_of(plant).stored(states_of(plant)), half, 1e-5 * half);
    }
  }
}

TEST(DcLink, AContactorThatIsHeldOpenNeverClosesAndOneThatIsWeldedIsClosedAtOnce) {
  const Parameters p{100e-6, 0.5, 0, false, 0, 0, 0, 0.0, 5.0, 0.9};
  for (const Contactor contactor : {Contactor::held_open, Contactor::welded}) {
    const bool welded = contactor == Contactor::welded;
    const double rc = p.capacitance * (p.source_resistance + (welded ? 0 : p.precharge_resistance));
    FixedStepIntegrator<Plant> integrator;
    Plant plant = plant_with(p, 0.0);
    PlantInputs<> inputs = idle();
    inputs.contactor = contactor;
    plant.set_inputs(inputs);
    const auto u = voltages(plant, integrator, 200);
    EXPECT_LT(largest_error(u, [&](double t) { return u_0 * -std::expm1(-t / rc); }), 1e-6 * u_0);
  }
}

// It opens while the capacitor is charged: what follows charges through the resistor again, and the contactor
// closes as soon as nothing holds it.
TEST(DcLink, AContactorOpensAndCloses) {
  const Parameters p{100e-6, 0.5, 0, false, 0, 0, 0, {}, 5.0, 0.9};
  FixedStepIntegrator<Plant> integrator;
  Plant plant = plant_with(p, u_0);
  PlantInputs<> inputs = idle();
  plant.set_inputs(inputs);
  EXPECT_TRUE(link_of(plant).is_closed()) << "charged from the beginning";
  Plant::State x = plant.state();
  x[Plant::appended] = 100.0;
  plant.set_state(x);
  EXPECT_TRUE(link_of(plant).is_closed()) << "however far the voltage falls";
  inputs.contactor = Contactor::held_open;
  plant.set_inputs(inputs);
  EXPECT_NEAR(link_of(plant).current(states_of(plant), u_0), 430 / 5.5, 1e-9);
  inputs.contactor = Contactor::automatic;
  plant.set_inputs(inputs);
  EXPECT_FALSE(link_of(plant).is_closed()) << "not charged";
  const auto u = voltages(plant, integrator, 200);
  EXPECT_NEAR(u.back(), u_0, 1e-3);
}

// The current of the inductance has nowhere to go: its energy is lost, and none of it from the account.
TEST(DcLink, WhatAnInductanceStoresIsLostWhereTheContactorOpens) {
  const Parameters p{100e-6, 0.5, 1e-3, false, 0, 0, 0, {}, 5.0, 0.9};
  FixedStepIntegrator<Plant> integrator;
  Plant plant = plant_with(p, u_0);
  PlantInputs<> inputs = idle();
  plant.set_inputs(inputs);
  Plant::State x = plant.state();
  x[Plant::appended] = 300.0;
  plant.set_state(x);
  const double before = link_of(plant).stored(states_of(plant));
  for (int n = 0; n < 8; ++n) ASSERT_TRUE(integrator.advance(plant, switching_period_ns));
  const double current = link_of(plant).current(states_of(plant), u_0);
  const double lost = states_of(plant)[Link::resistance];
  ASSERT_GT(current, 10);
  inputs.contactor = Contactor::held_open;
  plant.set_inputs(inputs);
  EXPECT_NEAR(states_of(plant)[Link::resistance], lost + 0.5 * 1e-3 * current * current, 1e-9);
  for (int n = 0; n < 100; ++n) ASSERT_TRUE(integrator.advance(plant, switching_period_ns));
  const auto y = states_of(plant);
  const double rest = y[Link::source] - y[Link::resistance] - (link_of(plant).stored(y) - before);
  EXPECT_LT(std::abs(rest), 1e-6 * y[Link::source]);
}

TEST(DcLink, IsNotValidBelowZeroVolts) {
  Plant plant = plant_with({1e-3, 0.2}, 100.0);
  plant.set_inputs(idle());
  EXPECT_TRUE(plant.is_reachable());
  Plant::State x = plant.state();
  x[Plant::appended] = -1e-3;
  plant.set_state(x);
  EXPECT_FALSE(plant.is_reachable());
}

DrivePlantParameters<> with_drops() {
  DrivePlantParameters<> p;
  p.drops = {1.2, 0.02};
  return p;
}

// What the inverter takes from the link at any state is what it passes on and what its devices take.
TEST(DcLink, PowerBalancesAtEachInstant) {
  for (const DrivePlantParameters<>& p : {DrivePlantParameters<>{}, with_drops()}) {
    Plant plant = plant_with({200e-6, 0.5}, u_0, p);
    FixedStepIntegrator<Plant> integrator;
    PlantInputs<> inputs = supply();
    double most = 0;
    int floating = 0;
    for (const SwitchState state : switching_sequence(4000, 5)) {
      inputs.state = most > 1e3 && floating < 200 ? SwitchState{state.a(), LegState::off, state.c()} : state;
      plant.set_inputs(inputs);
      ASSERT_TRUE(integrator.advance(plant, switching_period_ns));
      floating += inputs.state == state ? 0 : 1;
      const double p_dc = plant.u_dc() * plant.i_dc();
      const double p_ac = 1.5 * dot(plant.u_s(), plant.i_s()) + p.drops.threshold_loss(plant.i_s());
      most = std::max(most, std::abs(p_dc));
      // An idle leg may carry what the tolerance of its event leaves, 1e-4 A.
      EXPECT_NEAR(p_dc, p_ac, 1e-6 * std::abs(p_dc) + 2e-4 * plant.u_dc());
    }
    EXPECT_GT(most, 1e3);
  }
}

/// Supplied less lost, stored and passed to the inverter, by what has flowed.
double unaccounted(const Plant& plant, double stored_before, double field_before) {
  const auto y = states_of(plant);
  const auto energy = [&](Meter::Index i) { return plant.state()[Plant::appended + Link::size + int(i)]; };
  const double link_side = y[Link::source] - y[Link::resistance] - y[Link::chopper] -
                           (link_of(plant).stored(y) - stored_before) - energy(Meter::dc_link);
  const double lost = energy(Meter::stator_copper) + energy(Meter::rotor_copper);
  const double machine_side =
      energy(Meter::dc_link) - lost - energy(Meter::mechanical) - (plant.magnetic_energy() - field_before);
  return (std::abs(link_side) + std::abs(machine_side)) /
         (std::abs(y[Link::source]) + y[Link::resistance] + y[Link::chopper] + lost);
}

// With every leg driven, with gates off while a fast machine feeds the link through the diodes up to the
// chopper, and with a leg off.
TEST(DcLink, EnergyCloses) {
  const std::vector<Parameters> links{{1e-3, 0.2, 0, true, 15.0, 620.0, 600.0},
                                      {1e-3, 0.2},
                                      {200e-6, 0.5, 200e-6, false, 15.0, 620.0, 600.0},
                                      {200e-6, 0.5, 200e-6, true, 15.0, 620.0, 600.0}};
  for (const DrivePlantParameters<>& p : {DrivePlantParameters<>{}, with_drops()}) {
    for (const Parameters& link : links) {
      for (const Named& each : all_integrators()) {
        SCOPED_TRACE(each.name + ", " + std::to_string(link.capacitance) + " F");
        Plant plant = plant_with(link, u_0, p);
        PlantInputs<> inputs = supply();
        plant.set_inputs(inputs);
        plant.set_fluxes({1.1, 0.0}, {1.1, 0.0});
        plant.set_speed(350.0);
        const double stored = link_of(plant).stored(states_of(plant));
        const double field = plant.magnetic_energy();
        ASSERT_TRUE(run(plant, *each.integrator, std::vector<SwitchState>(100, gates_off), inputs));
        // A source that takes energy back leaves nothing to the chopper.
        EXPECT_EQ(states_of(plant)[Link::chopper] > 1.0, link.source_diode);
        ASSERT_TRUE(run(plant, *each.integrator, switching_sequence(1000, 11), inputs));
        std::vector<SwitchState> leg_off = switching_sequence(500, 12);
        for (SwitchState& state : leg_off) state = {state.a(), LegState::off, state.c()};
        ASSERT_TRUE(run(plant, *each.integrator, leg_off, inputs));
        EXPECT_TRUE(plant.is_reachable());
        EXPECT_LT(unaccounted(plant, stored, field), 1e-5);
      }
    }
  }
}

// The capacitor's charge over each segment is the integral of source current less the currents of the legs
// that are high, by Simpson's rule over states that are taken within the segment.
TEST(DcLink, RippleIsTheIntegralOfTheLegsCurrents) {
  const Parameters p{100e-6, 0.2, 2e-3};
  Plant plant = plant_with(p, u_0);
  FixedStepIntegrator<Plant> integrator;
  PlantInputs<> inputs = supply();
  const auto current_into_capacitor = [&](SwitchState s) {
    const ThreePhase<double> i = plant.i_abc();
    const auto high = [](LegState leg, double x) { return leg == LegState::high ? x : 0.0; };
    return states_of(plant)[Link::source_current] - high(s.a(), i.a) - high(s.b(), i.b) - high(s.c(), i.c);
  };
  double largest = 0;
  for (const SwitchState state : switching_sequence(4000, 3)) {
    inputs.state = state;
    plant.set_inputs(inputs);
    double charge = 0;
    const double before = plant.u_dc();
    for (int part = 0; part < 5; ++part) {
      charge += current_into_capacitor(state);
      ASSERT_TRUE(integrator.advance(plant, 2'500));
      charge += 4 * current_into_capacitor(state);
      ASSERT_TRUE(integrator.advance(plant, 2'500));
      charge += current_into_capacitor(state);
    }
    const double rise = charge * 5e-6 / 6 / p.capacitance;
    EXPECT_NEAR(plant.u_dc() - before, rise, 1e-6);
    largest = std::max(largest, std::abs(rise));
  }
  EXPECT_GT(largest, 5.0) << "in a period";
}

// Behind next to no resistance the link is stiff.
TEST(DcLink, BehindALowResistanceItIsTheStiffLink) {
  const DrivePlantParameters<> p;
  Stiff stiff{p, Meter{}};
  Plant linked = plant_with({1.0, 1e-5}, u_0);
  FixedStepIntegrator<Stiff> a;
  FixedStepIntegrator<Plant> b;
  for (const auto& part : {switching_sequence(2000, 4), std::vector<SwitchState>(100, gates_off)}) {
    ASSERT_TRUE(run(stiff, a, part, supply()));
    ASSERT_TRUE(run(linked, b, part, supply()));
    EXPECT_NEAR(linked.tau_e(), stiff.tau_e(), 1e-3);
    EXPECT_NEAR(linked.u_dc(), u_0, 1e-2);
  }
}

TEST(DcLink, IntegratorsAgreeAcrossEvents) {
  const Parameters p{100e-6, 0.5, 0, true, 15.0, 640.0, 600.0};
  const auto final_state = [&](PlantIntegrator<Plant>& integrator) {
    Plant plant = plant_with(p, u_0);
    PlantInputs<> inputs = supply();
    plant.set_inputs(inputs);
    plant.set_fluxes({1.1, 0.0}, {1.1, 0.0});
    plant.set_speed(350.0);
    int toggles = 0;
    bool on = false;
    for (const SwitchState state : switching_sequence(1500, 8)) {
      inputs.state = state;
      plant.set_inputs(inputs);
      EXPECT_TRUE(integrator.advance(plant, switching_period_ns));
      toggles += link_of(plant).chops() != on ? 1 : 0;
      on = link_of(plant).chops();
    }
    EXPECT_GT(toggles, 4);
    return plant.state();
  };
  FixedStepIntegrator<Plant> fine{FixedStepParameters{500}};
  const Plant::State truth = final_state(fine);
  for (const Named& each : all_integrators()) {
    SCOPED_TRACE(each.name);
    const Plant::State x = final_state(*each.integrator);
    EXPECT_LT((x - truth).head<4>().norm(), 1e-6);
    EXPECT_NEAR(x[Plant::omega], truth[Plant::omega], 1e-5);
    EXPECT_NEAR(x[Plant::appended], truth[Plant::appended], 1e-3);
  }
}

TEST(DcLink, JacobianIsTheSlopeOfTheRightHandSide) {
  Plant plant = plant_with({100e-6, 0.5, 1e-3}, u_0);
  PlantInputs<> inputs = supply();
  inputs.state = switch_states[2];
  plant.set_inputs(inputs);
  plant.set_fluxes({1.0, 0.3}, {0.9, 0.1});
  plant.set_speed(100.0);
  Plant::Jacobian j;
  plant.jacobian(plant.state(), j);
  constexpr int u = Plant::appended, i = Plant::appended + 1;
  EXPECT_NEAR(j(u, i), 1 / 100e-6, 1e-4 / 100e-6);
  EXPECT_NEAR(j(i, u), -1 / 1e-3, 1e-4 / 1e-3);
  EXPECT_NEAR(j(i, i), -0.5 / 1e-3, 1e-4 / 1e-3);
  const SpaceVector<> unit = stator_voltage(switch_states[2], 1.0);
  EXPECT_NEAR(j(Plant::psi_s_alpha, u), unit.alpha, 1e-6);
  EXPECT_NEAR(j(Plant::psi_s_beta, u), unit.beta, 1e-6);
  // C du/dt = −3/2 (u_s/u) · i_s
  EXPECT_NEAR(j(u, Plant::psi_s_alpha),
              -1.5 * unit.alpha / 100e-6 * plant.machine().inverse_inductance({}, {}).across,
              1e-4 / 100e-6 * plant.machine().inverse_inductance({}, {}).across);
}

TEST(DcLink, FloatAgreesWithDouble) {
  using FloatPlant = DrivePlant<float, DcLink<float>>;
  const DrivePlantParameters<float> p;
  FloatPlant plant{p, DcLink<float>{{1e-3F, 0.2F}, p.machine.sigma_l_s(), 0.0F}};
  PlantInputs<float> inputs{};
  inputs.u_dc = 530.0F;
  plant.set_inputs(inputs);
  FixedStepIntegrator<FloatPlant> integrator;
  for (int n = 0; n < 8; ++n) ASSERT_TRUE(integrator.advance(plant, switching_period_ns));
  EXPECT_NEAR(plant.u_dc(), 530 * -std::expm1(-1.0), 0.05);
}

// p/u has no bound where u falls to zero; from a tenth of the nominal voltage of the source down the current
// falls with u.
TEST(DcLink, ALossOfTheInverterLeavesAnEmptyLinkAlone) {
  constexpr double capacitance = 1e-3, source_u = 500, resistance = 0.2, p = 100;
  const DcLink<double> link{
      {.capacitance = capacitance, .source_resistance = resistance}, 5e-3, 0.0, source_u};
  const auto current = [&](double u) {
    std::array<double, 5> y{}, dy{};
    y[DcLink<double>::voltage] = u;
    PlantQuantities<> q{};
    q.u_given = source_u;
    q.inverter_loss = p;
    link.derivative(q, y, dy);
    return (source_u - u) / resistance - capacitance * dy[DcLink<double>::voltage];
  };
  for (const double u : {500.0, 200.0, 50.0}) EXPECT_NEAR(current(u), p / u, 1e-9);
  for (const double u : {10.0, 1.0, 1e-3, 0.0}) EXPECT_NEAR(current(u), p / 50 * (u / 50), 1e-9);
}

}  // namespace
}  // namespace sextant
