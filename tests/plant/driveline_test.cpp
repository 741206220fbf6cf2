// A load behind a shaft that twists and a gap, against closed forms, conservation, and the one mass it
// becomes.
#include "sextant/plant/driveline.hpp"

#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/dc_link.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Shaft = Driveline<double>;
using Contact = Shaft::Contact;
using Meter = EnergyMeter<double>;
using Parameters = DrivelineParameters<>;
using Plant = DrivePlant<double, AppendedPair<Shaft, Meter>>;
using Rigid = DrivePlant<double, Meter>;

constexpr double period_s = 1e-9 * double(switching_period_ns);

template <class P>
struct Named {
  std::string name;
  std::unique_ptr<PlantIntegrator<P>> integrator;
};

template <class P = Plant>
std::vector<Named<P>> all_integrators() {
  std::vector<Named<P>> all;
  CvodeParameters newton;
  newton.method = CvodeMethod::bdf_newton;
  all.push_back({"fixed", std::make_unique<FixedStepIntegrator<P>>()});
  all.push_back({"exact", std::make_unique<ExactIntegrator<P>>()});
  all.push_back({"erk", std::make_unique<ErkIntegrator<P>>()});
  all.push_back({"cvode", std::make_unique<CvodeIntegrator<P>>()});
  all.push_back({"cvode, Newton", std::make_unique<CvodeIntegrator<P>>(newton)});
  return all;
}

Plant plant_with(const Parameters& shaft, const DrivePlantParameters<>& p = {}, const RoadLoad<>& road = {}) {
  return Plant{p, {Shaft{shaft, p.machine.inertia, p.viscous_friction, road}, Meter{}}};
}

const Shaft& shaft_of(const Plant& plant) {
  return part_of<Shaft>(plant.appended_system());
}
Shaft::Values states_of(const Plant& plant) {
  return Shaft::Values{plant.state().data() + Plant::appended, std::size_t(Shaft::size)};
}
double slip_of(const Plant& plant) {
  return plant.omega_m() - states_of(plant)[Shaft::load_speed];
}
double torque_of(const Plant& plant) {
  return shaft_of(plant).torque(states_of(plant), plant.omega_m());
}

/// Of a machine without flux, whose gates are off: its torque is zero.
PlantInputs<> idle(double tau_l = 0.0) {
  PlantInputs<> inputs{};
  inputs.u_dc = 530.0;
  inputs.tau_l = tau_l;
  return inputs;
}

/// k = 1/J + 1/J_2 [1/(kg·m²)]
double mobility(const Parameters& shaft, const DrivePlantParameters<>& p = {}) {
  return 1 / p.machine.inertia + 1 / shaft.inertia;
}

/// x'' + d k x' + c k x = a from x = 0, x' = v; underdamped.
struct Swing {
  double decay, frequency, end, v;

  Swing(const Parameters& shaft, double k, double slip, double acceleration = 0)
      : decay{shaft.damping * k / 2},
        frequency{std::sqrt(shaft.stiffness * k - decay * decay)},
        end{acceleration / (shaft.stiffness * k)},
        v{slip} {}

  [[nodiscard]] double x(double t) const {
    return end + std::exp(-decay * t) * (-end * std::cos(frequency * t) +
                                         (v - decay * end) / frequency * std::sin(frequency * t));
  }
  [[nodiscard]] double slope(double t) const {
    const double s = (v - decay * end) / frequency;
    return std::exp(-decay * t) * ((decay * end + s * frequency) * std::cos(frequency * t) +
                                   (end * frequency - decay * s) * std::sin(frequency * t));
  }
};

/// From 3 % to 30 times the motor's inertia, 5 to 150 Hz, a damping ratio of 0 to 0.5.
Parameters random_shaft(std::mt19937& random, double gap) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<>{a, b}(random); };
  Parameters p;
  p.inertia = DrivePlantParameters<>{}.machine.inertia * std::pow(10, between(-1.5, 1.5));
  const double k = mobility(p);
  const double frequency = 2 * std::numbers::pi * std::pow(10, between(0.7, 2.2));
  p.stiffness = frequency * frequency / k;
  p.damping = 2 * between(0, 0.5) * frequency / k;
  p.backlash = gap * between(0.5, 2);
  return p;
}

TEST(Driveline, ParametersAreChecked) {
  const auto problem = [](const Parameters& p) {
    return std::string{p.validate() == nullptr ? "" : p.validate()};
  };
  EXPECT_EQ(problem({}), "");
  EXPECT_EQ(problem({0.1, 1e3}), "");
  EXPECT_EQ(problem({0.1, 1e3, 1, 0.02, 8}), "");
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Parameters& p : {Parameters{-0.1, 1e3}, Parameters{nan, 1e3}, Parameters{0.1, INFINITY},
                              Parameters{0.1, 1e3, -1}, Parameters{0.1, 1e3, 1, -0.01}})
    EXPECT_THAT(problem(p), HasSubstr("finite and not below zero"));
  for (const double ratio : {0.0, -1.0, nan, double{INFINITY}})
    EXPECT_THAT(problem({0.1, 1e3, 1, 0, ratio}),
                HasSubstr("gear ratio of the driveline must be above zero"));
  for (const Parameters& p :
       {Parameters{0, 1e3}, Parameters{0, 0, 1}, Parameters{0, 0, 0, 0.01}, Parameters{0, 0, 0, 0, 2}})
    EXPECT_THAT(problem(p), HasSubstr("need a driveline with an inertia above zero"));
  EXPECT_THAT(problem({0.1, 0}), HasSubstr("stiffness must be above zero"));
}

// Frequency and decay of the two-mass eigenvalues  −dk/2 ± j√(ck − (dk/2)²),  by the zeros of the twist and
// by its course; the common speed stays.
TEST(Driveline, SwingsWithTheEigenvaluesOfTwoMasses) {
  constexpr unsigned seed = 20261126;
  std::mt19937 random{seed};
  for (int n = 0; n < 6; ++n) {
    const Parameters p = random_shaft(random, 0);
    const double k = mobility(p);
    const Swing swing{p, k, 10};
    for (const auto& each : all_integrators()) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::to_string(n) + ", " + each.name);
      Plant plant = plant_with(p);
      plant.set_inputs(idle());
      plant.set_speed(10);
      const double momentum = plant.machine().parameters().inertia * 10;
      std::vector<double> zeros;
      double worst = 0, before = 0;
      const auto periods = int(2.2 * 2 * std::numbers::pi / swing.frequency / period_s);
      for (int m = 1; m <= periods; ++m) {
        ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
        const double twist = states_of(plant)[Shaft::twist];
        worst = std::max(worst, std::abs(twist - swing.x(m * period_s)));
        if (m > 1 && before * twist < 0) zeros.push_back((m - twist / (twist - before)) * period_s);
        before = twist;
        ASSERT_NEAR(plant.machine().parameters().inertia * plant.omega_m() +
                        p.inertia * states_of(plant)[Shaft::load_speed],
                    momentum, 1e-9 * momentum);
      }
      EXPECT_LT(worst, 1e-7 * 10 / swing.frequency);
      ASSERT_GE(zeros.size(), 4U);
      // A zero lies on a chord of a period, which at 150 Hz is a sixtieth of a half swing.
      EXPECT_NEAR((zeros[3] - zeros[0]) / 3, std::numbers::pi / swing.frequency,
                  1e-5 * std::numbers::pi / swing.frequency);
    }
  }
}

// Load torque to speeds of load and motor, with s = jω and the sign of a torque that brakes,
//   −ω_2/tau_l = (J s² + d s + c)/N,  −ω_1/tau_l = (d s + c)/N,  N = s (J J_2 s² + (J + J_2)(d s + c)),
// at the antiresonance √(c/J), where the motor absorbs the swing of the load, at the resonance, and apart.
TEST(Driveline, HasTheFrequencyResponseOfTwoMasses) {
  const DrivePlantParameters<> defaults;
  const double j = defaults.machine.inertia;
  Parameters p;
  p.inertia = 0.5 * j;
  p.stiffness = j * std::pow(2 * std::numbers::pi * 40, 2);
  p.damping = 0.05 * p.stiffness / (2 * std::numbers::pi * 40);
  const double resonance = std::sqrt(p.stiffness * mobility(p));
  using Complex = std::complex<double>;
  double at_antiresonance = 0;
  for (const double omega : {2 * std::numbers::pi * 40, resonance, 2 * std::numbers::pi * 20}) {
    constexpr int steps = 1000;  // of a cycle
    const double cycle_s = 2 * std::numbers::pi / omega;
    const auto step_ns = std::int64_t(std::llround(cycle_s / steps * 1e9));
    const double true_omega = 2 * std::numbers::pi / (steps * 1e-9 * double(step_ns));
    Plant plant = plant_with(p);
    FixedStepIntegrator<Plant> integrator;
    Complex torque = 0, load = 0, motor = 0;
    constexpr int cycles = 60;
    for (int n = 0; n < cycles * steps; ++n) {
      const double phase = 2 * std::numbers::pi * (n + 0.5) / steps;
      const double tau_l = 10 * std::cos(phase);
      plant.set_inputs(idle(tau_l));
      ASSERT_TRUE(integrator.advance(plant, step_ns));
      if (n < (cycles - 1) * steps) continue;
      torque += tau_l * std::polar(1.0, -phase);
      const Complex turned = std::polar(1.0, -phase - std::numbers::pi / steps);  // at the end of the step
      load += states_of(plant)[Shaft::load_speed] * turned;
      motor += plant.omega_m() * turned;
    }
    const Complex s{0, true_omega};
    const Complex soft = p.damping * s + p.stiffness;
    const Complex n = s * (j * p.inertia * s * s + (j + p.inertia) * soft);
    EXPECT_LT(std::abs(-load / torque - (j * s * s + soft) / n), 1e-4 * std::abs(soft / n)) << omega;
    EXPECT_LT(std::abs(-motor / torque - soft / n), 1e-4 * std::abs(soft / n)) << omega;
    if (at_antiresonance == 0) {
      at_antiresonance = std::abs(load / torque);
      EXPECT_LT(at_antiresonance, 0.06 * std::abs(motor / torque));
    }
  }
}

// At a constant torque the gap is crossed in √(2 b J_2/tau_l); then the flank swings from b on.
TEST(Driveline, CrossesTheGapInTheTimeOfAConstantTorque) {
  constexpr double tau_l = 20;
  for (const Parameters& p : {Parameters{0.05, 2e3, 0, 0.037}, Parameters{0.05, 2e3, 2, 0.037}}) {
    const double b = p.backlash / 2;
    const double crossing = std::sqrt(2 * b * p.inertia / tau_l);
    const Swing swing{p, mobility(p), tau_l / p.inertia * crossing, tau_l / p.inertia};
    for (const auto& each : all_integrators()) {
      SCOPED_TRACE(each.name);
      Plant plant = plant_with(p);
      plant.set_inputs(idle(tau_l));
      double t = 0;
      while (t < crossing + 0.4 * 2 * std::numbers::pi / swing.frequency) {
        ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
        t += period_s;
        EXPECT_EQ(Shaft::contact(states_of(plant)) == Contact::neither, t < crossing) << t;
        EXPECT_EQ(torque_of(plant) == 0.0, t < crossing) << t;
        const double twist = t < crossing ? tau_l / p.inertia * t * t / 2 : b + swing.x(t - crossing);
        // The contact begins 1e-9 rad late.
        EXPECT_NEAR(states_of(plant)[Shaft::twist], twist, 1e-8) << t;
      }
    }
  }
}

// Flanks that meet with the slip v part with e v, where c x + d x' has fallen to zero:
//   tan(ω t) = −d ω/(c − d σ),  e = |x'(t)|/v,
// again and again from side to side. The momentum stays; of the energy ½ v²/k the share 1 − e² is lost.
TEST(Driveline, FlanksPartWhereTheirTorqueIsZero) {
  constexpr unsigned seed = 7;
  std::mt19937 random{seed};
  for (int n = 0; n < 6; ++n) {
    const Parameters p = random_shaft(random, 0.05);
    const double k = mobility(p), v = 5;
    const Swing swing{p, k, v};
    const double contact_s =
        std::atan2(p.damping * swing.frequency, p.damping * swing.decay - p.stiffness) / swing.frequency;
    const double restitution = -swing.slope(contact_s) / v;
    ASSERT_GT(restitution, 0.2);
    for (const auto& each : all_integrators()) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::to_string(n) + ", " + each.name);
      Plant plant = plant_with(p);
      plant.set_inputs(idle());
      plant.set_speed(v);
      const double inertia = plant.machine().parameters().inertia;
      int contacts = 0;
      bool touched = false;
      double t = 0, expected = v;
      while (contacts < 3 && t < 20) {
        ASSERT_TRUE(each.integrator->advance(plant, switching_period_ns));
        t += period_s;
        const bool touches = Shaft::contact(states_of(plant)) != Contact::neither;
        if (touched && !touches) {
          ++contacts;
          expected *= -restitution;
          EXPECT_NEAR(slip_of(plant), expected, 1e-6 * v);
        }
        touched = touches;
        const auto y = states_of(plant);
        ASSERT_NEAR(inertia * plant.omega_m() + p.inertia * y[Shaft::load_speed], inertia * v,
                    1e-9 * inertia * v);
        const double energy = shaft_of(plant).kinetic_energy(y, plant.omega_m()) +
                              shaft_of(plant).elastic_energy(y) + y[Shaft::damping];
        ASSERT_NEAR(energy, inertia * v * v / 2, 1e-6 * inertia * v * v / 2);
      }
      EXPECT_EQ(contacts, 3);
    }
  }
}

/// A random course of the machine and a load torque that changes its sign.
template <class Look>
void go_through(Plant& plant, PlantIntegrator<Plant>& integrator, unsigned seed, Look look) {
  PlantInputs<> inputs = supply();
  plant.set_inputs(inputs);
  plant.set_fluxes({1.1, 0.0}, {1.1, 0.0});
  int n = 0;
  for (const SwitchState state : switching_sequence(2400, seed)) {
    inputs.state = n < 200 ? gates_off : state;
    inputs.tau_l = n / 300 % 2 == 0 ? 15.0 : -15.0;
    plant.set_inputs(inputs);
    ASSERT_TRUE(integrator.advance(plant, switching_period_ns));
    look();
    ++n;
  }
}

TEST(Driveline, AContactOnlyPushesAndEnergyCloses) {
  constexpr unsigned seed = 3;
  std::mt19937 random{seed};
  int ahead = 0, behind = 0;
  for (int n = 0; n < 6; ++n) {
    const Parameters p = random_shaft(random, n % 3 == 0 ? 0.0 : 0.01);
    DrivePlantParameters<> motor;
    motor.viscous_friction = 0.01;
    const RoadLoad<> road{.quadratic_drag = 1e-4, .rolling_torque = 2, .coupled_inertia = 0.01};
    for (const auto& each : all_integrators()) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::to_string(n) + ", " + each.name);
      Plant plant = plant_with(p, motor, road);
      const double field = [] {
        Plant magnetised = plant_with({0.1, 1e3});
        magnetised.set_fluxes({1.1, 0.0}, {1.1, 0.0});
        return magnetised.magnetic_energy();
      }();
      go_through(plant, *each.integrator, seed + unsigned(n), [&] {
        const double tau = plant.acting(plant.inputs()).tau_l;
        const Contact contact = Shaft::contact(states_of(plant));
        ahead += contact == Contact::ahead;
        behind += contact == Contact::behind;
        const double rounding = 1e-9 * p.stiffness;
        if (p.backlash == 0) return;
        EXPECT_GE(contact == Contact::behind ? 0.0 : tau, -rounding);
        EXPECT_LE(contact == Contact::ahead ? 0.0 : tau, rounding);
        EXPECT_GE(torque_of(plant) * double(int(contact)), 0.0);
      });
      const auto y = states_of(plant);
      const auto metered = [&](Meter::Index i) {
        return plant.state()[Plant::appended + Shaft::size + int(i)];
      };
      const double stored =
          shaft_of(plant).kinetic_energy(y, plant.omega_m()) + shaft_of(plant).elastic_energy(y);
      const double flowed = std::abs(metered(Meter::mechanical)) + y[Shaft::friction] + y[Shaft::damping] +
                            std::abs(y[Shaft::load]) + stored;
      EXPECT_GT(flowed, 1.0);
      EXPECT_NEAR(metered(Meter::mechanical),
                  y[Shaft::friction] + y[Shaft::damping] + y[Shaft::load] + stored, 1e-6 * flowed);
      const double copper = metered(Meter::stator_copper) + metered(Meter::rotor_copper);
      EXPECT_NEAR(metered(Meter::dc_link),
                  copper + metered(Meter::mechanical) + plant.magnetic_energy() - field, 1e-6 * copper);
    }
  }
  EXPECT_GT(ahead, 1000);
  EXPECT_GT(behind, 1000);
}

// With the stiffness the driveline becomes one mass, the deviation by its inverse.
TEST(Driveline, AStiffShaftIsOneMass) {
  Parameters p{0.1, 1e4, 0};
  DrivePlantParameters<> one;
  one.machine.inertia += p.inertia;
  std::vector<double> deviations;
  for (const double stiffness : {1e4, 1e5, 1e6}) {
    p.stiffness = stiffness;
    p.damping = 0.02 * std::sqrt(stiffness / mobility(p));
    Plant plant = plant_with(p);
    Rigid rigid{one, Meter{}};
    FixedStepIntegrator<Plant> a;
    FixedStepIntegrator<Rigid> b;
    const auto sequence = switching_sequence(4000, 4);
    double deviation = 0;
    for (const SwitchState state : sequence) {
      ASSERT_TRUE(run(plant, a, {state}, supply()));
      ASSERT_TRUE(run(rigid, b, {state}, supply()));
      deviation = std::max(deviation, std::abs(plant.omega_m() - rigid.omega_m()));
    }
    deviations.push_back(deviation);
  }
  EXPECT_GT(deviations[0], 1e-3);
  // A step of the torque winds up the shaft with the amplitude Δω ~ tau √(k/c).
  EXPECT_LT(deviations[1], deviations[0] / 2.5);
  EXPECT_LT(deviations[2], deviations[1] / 2.5);
}

// A ratio n is the driveline that `referred` gives, with n times less load torque.
TEST(Driveline, AGearIsItsReferredDriveline) {
  const Parameters p{0.4, 800, 1.5, 0.01, 4};
  const RoadLoad<> road{1e-3, 8, 1, 2, 0.16};
  const RoadLoad<> referred_road{1e-3 / 64, 2, 4, 0.5, 0.01};
  EXPECT_EQ(p.referred(), (Parameters{0.025, 50, 1.5 / 16, 0.04, 1}));
  Plant geared = plant_with(p, {}, road);
  Plant direct = plant_with(p.referred(), {}, referred_road);
  FixedStepIntegrator<Plant> integrator;
  PlantInputs<> inputs = supply();
  for (const SwitchState state : switching_sequence(2000, 9)) {
    inputs.state = state;
    inputs.tau_l = 20;
    geared.set_inputs(inputs);
    inputs.tau_l = 5;
    direct.set_inputs(inputs);
    ASSERT_TRUE(integrator.advance(geared, switching_period_ns));
    ASSERT_TRUE(integrator.advance(direct, switching_period_ns));
    ASSERT_LT((geared.state() - direct.state()).norm(), 1e-9);
  }
  EXPECT_GT(std::abs(direct.omega_m()), 1);
}

TEST(Driveline, IntegratorsAgreeAcrossContacts) {
  const Parameters p{0.02, 500, 0.2, 0.01};
  const auto final_state = [&](PlantIntegrator<Plant>& integrator, int& contacts) {
    Plant plant = plant_with(p);
    Contact before = Contact::neither;
    contacts = 0;
    go_through(plant, integrator, 8, [&] {
      contacts += Shaft::contact(states_of(plant)) != before;
      before = Shaft::contact(states_of(plant));
    });
    return plant.state();
  };
  int contacts = 0;
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1000}};
  const Plant::State truth = final_state(fine, contacts);
  EXPECT_GT(contacts, 4);
  for (const auto& each : all_integrators()) {
    SCOPED_TRACE(each.name);
    int found = 0;
    const Plant::State x = final_state(*each.integrator, found);
    EXPECT_EQ(found, contacts);
    EXPECT_LT((x - truth).head<4>().norm(), 1e-6);
    EXPECT_LT((x - truth).segment(Plant::omega, 5).norm(), 1e-4);
  }
}

TEST(Driveline, JacobianIsTheSlopeOfTheRightHandSide) {
  const Parameters p{0.05, 1e3, 0.5};
  Plant plant = plant_with(p);
  plant.set_inputs(supply());
  plant.set_speed(100.0);
  Plant::Jacobian j;
  plant.jacobian(plant.state(), j);
  constexpr int phi = Plant::appended, load = Plant::appended + 1, motor = Plant::omega;
  const double inertia = DrivePlantParameters<>{}.machine.inertia;
  EXPECT_NEAR(j(phi, motor), 1, 1e-6);
  EXPECT_NEAR(j(phi, load), -1, 1e-6);
  EXPECT_NEAR(j(load, phi), 1e3 / 0.05, 1e-5 * 1e3 / 0.05);
  EXPECT_NEAR(j(load, load), -0.5 / 0.05, 1e-4);
  EXPECT_NEAR(j(motor, phi), -1e3 / inertia, 1e-5 * 1e3 / inertia);
  EXPECT_NEAR(j(motor, motor), -0.5 / inertia, 1e-4);
}

// A link whose voltage is a state beside it: each acts as it does alone.
TEST(Driveline, StandsBesideALink) {
  using Link = DcLink<double>;
  using Both = DrivePlant<double, AppendedPair<AppendedPair<Link, Shaft>, Meter>>;
  using Linked = DrivePlant<double, AppendedPair<Link, Meter>>;
  const DrivePlantParameters<> defaults;
  const Meter meter{};
  const Parameters p{0.05, 1e3, 0.5, 0.02};
  const Shaft shaft{p, defaults.machine.inertia, 0};
  const auto link = [&](double capacitance, double resistance) {
    return Link{{capacitance, resistance}, defaults.machine.sigma_l_s(), 530};
  };
  Both soft_link{defaults, {{link(1e-3, 0.5), shaft}, meter}};
  Both stiff_link{defaults, {{link(1.0, 1e-5), shaft}, meter}};
  Plant stiff{defaults, {shaft, meter}};
  Linked linked{defaults, {link(1e-3, 0.5), meter}};
  FixedStepIntegrator<Both> a;
  FixedStepIntegrator<Plant> b;
  FixedStepIntegrator<Linked> c;
  const auto sequence = switching_sequence(3000, 5);
  ASSERT_TRUE(run(soft_link, a, sequence, supply()));
  ASSERT_TRUE(run(stiff_link, a, sequence, supply()));
  ASSERT_TRUE(run(stiff, b, sequence, supply()));
  ASSERT_TRUE(run(linked, c, sequence, supply()));
  constexpr int twist = part_begin<Shaft, Both::AppendedType>();
  static_assert(twist == Link::size && part_begin<Meter, Both::AppendedType>() == Link::size + Shaft::size);
  EXPECT_NEAR(stiff_link.omega_m(), stiff.omega_m(), 1e-3);
  EXPECT_NEAR(stiff_link.state()[Both::appended + twist], states_of(stiff)[Shaft::twist], 1e-5);
  EXPECT_LT(soft_link.u_dc(), 529.9);
  EXPECT_GT(std::abs(soft_link.omega_m() - linked.omega_m()), 0.1);
}

TEST(Driveline, FloatAgreesWithDouble) {
  using FloatPlant = DrivePlant<float, Driveline<float>>;
  const DrivePlantParameters<float> p;
  const DrivelineParameters<float> shaft{0.05F, 1e3F, 0.5F, 0.02F};
  FloatPlant plant{p, Driveline<float>{shaft, p.machine.inertia, 0.0F}};
  Plant reference = plant_with({0.05, 1e3, 0.5, 0.02});
  plant.set_speed(20);
  reference.set_inputs(idle());
  reference.set_speed(20);
  FixedStepIntegrator<FloatPlant> a;
  FixedStepIntegrator<Plant> b;
  for (int n = 0; n < 1000; ++n) {
    ASSERT_TRUE(a.advance(plant, switching_period_ns));
    ASSERT_TRUE(b.advance(reference, switching_period_ns));
  }
  EXPECT_NEAR(plant.omega_m(), reference.omega_m(), 0.01);
  EXPECT_GT(std::abs(reference.omega_m() - 20), 1);
}

}  // namespace
}  // namespace sextant
