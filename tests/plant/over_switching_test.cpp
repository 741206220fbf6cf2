// Integrators that go on over the switching of the inverter, against one that stops at each: patterns of
// several segments, symmetric and not, on two machines and at two periods.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/mean_voltage.hpp"
#include "sextant/plant/smooth_state.hpp"
#include "sextant/plant/voltage_integral.hpp"
#include "sextant/plant/voltage_parabola.hpp"

namespace sextant {
namespace {

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;
using Corners = std::array<Plant::State, GatePattern::capacity>;

constexpr double u_dc = 530;

/// Two active vectors of the sixth that the angle lies in and both zero vectors, for the time that the depth
/// of modulation and the angle say. Symmetric: seven segments about the middle; else three from the
/// beginning.
GatePattern modulated(double angle, double depth, std::int32_t period_ns, bool symmetric) {
  const double sixth = M_PI / 3;
  const auto n = static_cast<std::size_t>(std::floor(angle / sixth));
  const double inside = angle - double(n) * sixth;
  const auto first_ns = std::int32_t(depth * std::sin(sixth - inside) * period_ns);
  const auto second_ns = std::int32_t(depth * std::sin(inside) * period_ns);
  const SwitchState first = switch_states[1 + n % 6], second = switch_states[1 + (n + 1) % 6];
  const std::int32_t zero_ns = period_ns - first_ns - second_ns;
  GatePattern p;
  if (!symmetric) {
    p.append({first, first_ns});
    p.append({second, second_ns});
    p.append({switch_states[0], zero_ns});
    return p;
  }
  const std::int32_t outer_ns = zero_ns / 4, half_first_ns = first_ns / 2, half_second_ns = second_ns / 2;
  p.append({switch_states[0], outer_ns});
  p.append({first, half_first_ns});
  p.append({second, half_second_ns});
  p.append({switch_states[7], period_ns - 2 * (outer_ns + half_first_ns + half_second_ns)});
  p.append({second, half_second_ns});
  p.append({first, half_first_ns});
  p.append({switch_states[0], outer_ns});
  return p;
}

/// A field that turns at that frequency, its depth in proportion to the speed and shaken at random.
std::vector<GatePattern> field(double hz, std::int32_t period_ns, double seconds, bool symmetric,
                               unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> shake{-0.02, 0.02};
  std::vector<GatePattern> patterns;
  const auto periods = std::int64_t(seconds * 1e9) / period_ns;
  for (std::int64_t k = 0; k < periods; ++k) {
    const double angle = std::fmod(2 * M_PI * hz * double(k * period_ns) * 1e-9, 2 * M_PI);
    patterns.push_back(modulated(angle, 0.05 + 0.011 * hz + shake(random), period_ns, symmetric));
  }
  return patterns;
}

DrivePlantParameters<double> light_shaft() {
  DrivePlantParameters<double> p;
  p.machine.inertia = 0.05;
  return p;
}

/// An eight-pole machine with some ten times the leakage rates of the default one.
DrivePlantParameters<double> small_machine() {
  DrivePlantParameters<double> p;
  p.machine.r_s = 24.5;
  p.machine.r_r = 21.0;
  p.machine.l_m = 0.75;
  p.machine.l_ls = p.machine.l_lr = 0.055;
  p.machine.pole_pairs = 4;
  p.machine.inertia = 0.002;
  return p;
}

Plant start(const DrivePlantParameters<double>& p) {
  Plant plant{p, Meter{}};
  plant.set_inputs({switch_states[0], u_dc, 0.5, false, 0.0});
  return plant;
}

double torque(const Plant& plant, const Plant::State& x) {
  return plant.quantities(x.head<Plant::machine_size>()).tau_e;
}

struct Errors {
  double torque{};   // at corners and ends, by the peak
  double energy{};   // drawn from the link, by what flowed
  double balance{};  // unaccounted, by what flowed
};

Errors against_small_steps(PlantIntegrator<Plant>& integrator, const DrivePlantParameters<double>& p,
                           const std::vector<GatePattern>& patterns) {
  Plant reference = start(p), plant = start(p);
  FixedStepIntegrator<Plant> small{{.max_step_ns = 2'000, .at_switching = AtSwitching::stop}};
  Corners expected, found;
  double peak = 0, worst = 0;
  for (const GatePattern& pattern : patterns) {
    const auto segments = pattern.segments();
    EXPECT_TRUE(small.advance_through(reference, segments, {expected.data(), segments.size()}));
    EXPECT_TRUE(integrator.advance_through(plant, segments, {found.data(), segments.size()}));
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const double now = torque(reference, expected[k]);
      peak = std::max(peak, std::abs(now));
      worst = std::max(worst, std::abs(torque(plant, found[k]) - now));
    }
    EXPECT_EQ(found[segments.size() - 1], plant.state());
    EXPECT_EQ(plant.inputs().state, pattern.last_state());
  }
  const auto energy = [](const Plant& x, Meter::Index i) { return x.state()[Plant::appended + int(i)]; };
  const double copper = energy(plant, Meter::stator_copper) + energy(plant, Meter::rotor_copper);
  const double flowed = std::abs(energy(plant, Meter::dc_link)) + copper;
  const double left =
      energy(plant, Meter::dc_link) - copper - energy(plant, Meter::mechanical) - plant.magnetic_energy();
  return {worst / peak, std::abs(energy(plant, Meter::dc_link) - energy(reference, Meter::dc_link)) / flowed,
          std::abs(left) / flowed};
}

struct Case {
  std::string name;
  DrivePlantParameters<double> plant;
  std::int32_t period_ns;
  double hz;
  bool symmetric;
  double limit;  // of the torque's error by its peak, and of the energy's; of third order in period and rates
};

std::vector<Case> cases() {
  return {{"light shaft, 25 us, symmetric", light_shaft(), 25'000, 25, true, 2e-5},
          {"light shaft, 25 us, asymmetric", light_shaft(), 25'000, 25, false, 2e-5},
          {"light shaft, 25 us, standstill", light_shaft(), 25'000, 0, true, 2e-5},
          {"light shaft, 25 us, 75 Hz", light_shaft(), 25'000, 75, true, 2e-5},
          {"small machine, 100 us, symmetric", small_machine(), 100'000, 40, true, 6e-5}};
}

struct Contestant {
  std::string name;
  std::unique_ptr<PlantIntegrator<Plant>> integrator;
};

std::vector<Contestant> contestants() {
  std::vector<Contestant> list;
  list.push_back({"fixed", std::make_unique<FixedStepIntegrator<Plant>>()});
  list.push_back({"cvode", std::make_unique<CvodeIntegrator<Plant>>()});
  list.push_back(
      {"cvode, bdf", std::make_unique<CvodeIntegrator<Plant>>(CvodeParameters{{}, CvodeMethod::bdf_newton})});
  list.push_back({"erk", std::make_unique<ErkIntegrator<Plant>>()});
  return list;
}

TEST(OverSwitching, TorqueAtEveryCornerIsThatOfSmallStepsThatStop) {
  for (const Case& c : cases()) {
    const auto patterns = field(c.hz, c.period_ns, 0.25, c.symmetric, 71);
    for (const Contestant& one : contestants()) {
      SCOPED_TRACE(c.name + ", " + one.name);
      const Errors errors = against_small_steps(*one.integrator, c.plant, patterns);
      std::printf("%-36s %-10s torque %.1e energy %.1e balance %.1e\n", c.name.c_str(), one.name.c_str(),
                  errors.torque, errors.energy, errors.balance);
      EXPECT_LT(errors.torque, c.limit);
      EXPECT_LT(errors.energy, c.limit);
      EXPECT_LT(errors.balance, 1e-5);
    }
  }
}

TEST(OverSwitching, StoppingIsTheSameAsOneSegmentAfterTheOther) {
  FixedStepIntegrator<Plant> stops{{.at_switching = AtSwitching::stop}}, by_hand{{}};
  Plant plant = start(light_shaft()), expected = start(light_shaft());
  Corners corners;
  for (const GatePattern& pattern : field(25, 25'000, 0.02, true, 72)) {
    ASSERT_TRUE(
        stops.advance_through(plant, pattern.segments(), {corners.data(), pattern.segments().size()}));
    std::size_t k = 0;
    for (const GateSegment& segment : pattern.segments()) {
      expected.set_switch_state(segment.state);
      ASSERT_TRUE(by_hand.advance(expected, segment.duration_ns));
      ASSERT_EQ(corners[k++], expected.state());
    }
  }
}

/// The voltage of a standing vector integrates without end, which must cost no accuracy.
TEST(OverSwitching, AStandingVectorForSecondsStaysAccurate) {
  const GatePattern pattern = modulated(0.2, 0.02, 25'000, true);
  CvodeIntegrator<Plant> cvode;
  Plant plant = start(light_shaft());
  PlantInputs<double> inputs = plant.inputs();
  inputs.imposed_speed = true;
  plant.set_inputs(inputs);
  for (int k = 0; k < 200'000; ++k) ASSERT_TRUE(cvode.advance_through(plant, pattern.segments(), {}));
  // After 5 s the mean current is the mean voltage by the resistance.
  const VoltageIntegral<double> voltage{pattern.segments(), u_dc};
  const SpaceVector<> mean = (1.0 / 25e-6) * voltage.end().v;
  const double r_s = plant.machine().parameters().r_s;
  EXPECT_NEAR(r_s * plant.i_s().alpha, mean.alpha, 2e-3 * magnitude(mean));
  EXPECT_NEAR(r_s * plant.i_s().beta, mean.beta, 2e-3 * magnitude(mean));
}

/// What is no switching ends the solution: a state from outside, gates off, another kind of shaft.
TEST(OverSwitching, JumpsAreTakenUp) {
  for (const Contestant& one : contestants()) {
    SCOPED_TRACE(one.name);
    Plant plant = start(light_shaft()), reference = start(light_shaft());
    FixedStepIntegrator<Plant> small{{.max_step_ns = 2'000, .at_switching = AtSwitching::stop}};
    const auto both = [&](auto&& change) {
      change(plant);
      change(reference);
    };
    const auto run = [&](const GatePattern& pattern) {
      ASSERT_TRUE(one.integrator->advance_through(plant, pattern.segments(), {}));
      ASSERT_TRUE(small.advance_through(reference, pattern.segments(), {}));
    };
    const auto patterns = field(25, 25'000, 0.1, true, 73);
    for (std::size_t k = 0; k < patterns.size(); ++k) {
      if (k == 1000) both([](Plant& x) { x.set_speed(30.0); });
      if (k == 1500 || k == 1600)
        both([k](Plant& x) {
          PlantInputs<double> inputs = x.inputs();
          inputs.imposed_speed = k == 1500;
          inputs.speed_slope = 10.0;
          x.set_inputs(inputs);
        });
      if (k == 2000)
        both([](Plant& x) {
          PlantInputs<double> inputs = x.inputs();
          inputs.tau_l = -20.0;
          inputs.u_dc = 400.0;
          x.set_inputs(inputs);
        });
      if (k == 2000) one.integrator->reset();
      run(k >= 2500 && k < 2540 ? GatePattern{gates_off, 25'000} : patterns[k]);
    }
    EXPECT_LT(magnitude(plant.psi_s() - reference.psi_s()), 1e-5);
    EXPECT_LT(magnitude(plant.psi_r() - reference.psi_r()), 1e-5);
    EXPECT_NEAR(plant.omega_m(), reference.omega_m(), 1e-4);
  }
}

TEST(OverSwitching, TightTolerancesStop) {
  ErrorControl p;
  EXPECT_FALSE(p.stops());
  EXPECT_EQ(p.tolerances(p.stops()).relative, 1e-7);
  p.relative_tolerance = 1e-6;
  EXPECT_FALSE(p.stops());
  p.relative_tolerance = 0.99e-7;
  EXPECT_TRUE(p.stops());
  EXPECT_EQ(p.tolerances(true).relative, 0.99e-7);
  EXPECT_EQ(p.tolerances(true).speed, 1e-11);
  p.at_switching = AtSwitching::go_on;
  EXPECT_FALSE(p.stops());
  EXPECT_NE(FixedStepParameters{.at_switching = AtSwitching::by_tolerance}.validate(), nullptr);
}

TEST(VoltageIntegral, IsTheIntegralOfTheVoltageAndOfItself) {
  const GatePattern pattern = modulated(2.0, 0.7, 25'000, true);
  const VoltageIntegral<double> voltage{pattern.segments(), u_dc};
  // Rectangles of half a nanosecond.
  SpaceVector<> v{}, a{};
  double t = 0;
  std::size_t k = 0;
  for (const GateSegment& segment : pattern.segments()) {
    const SpaceVector<> u_s = stator_voltage(segment.state, u_dc);
    for (int n = 0; n < 2 * segment.duration_ns; ++n) {
      a += 0.5e-9 * (v + 0.25e-9 * u_s);
      v += 0.5e-9 * u_s;
    }
    t += 1e-9 * segment.duration_ns;
    EXPECT_NEAR(voltage.corner(k), t, 1e-18);
    EXPECT_LT(magnitude(voltage.at_corner(k).v - v), 1e-12);
    EXPECT_LT(magnitude(voltage(t).a - a), 1e-16);
    ++k;
  }
  EXPECT_EQ(voltage.size(), k);
  EXPECT_LT(magnitude(voltage.end().v - v), 1e-12);
}

TEST(VoltageParabola, HasTheEndsAndTheAreaOfTheIntegral) {
  const GatePattern pattern = modulated(0.7, 0.6, 25'000, false);
  const VoltageIntegral<double> voltage{pattern.segments(), u_dc};
  const double begin = 4e-6, h = 17e-6;
  const VoltageMoments<> m0 = voltage(begin), m1 = voltage(begin + h);
  const VoltageParabola<double> parabola{m0, m1, h};
  EXPECT_LT(magnitude(parabola.rise() - (m1.v - m0.v)), 1e-15);
  // Simpson's rule is exact for a parabola.
  const SpaceVector<> area = (h / 6) * (4.0 * parabola.middle() + parabola.rise());
  EXPECT_LT(magnitude(area - (m1.a - m0.a - h * m0.v)), 1e-20);
}

TEST(MeanVoltage, HasTheRiseAndTheMeansOfTheIntegrals) {
  const GatePattern pattern = modulated(0.7, 0.6, 25'000, false);
  const VoltageIntegral<double> voltage{pattern.segments(), u_dc};
  const VoltageMoments<> begin{{0.3, -0.1}, {2e-3, 1e-3}};
  const MeanVoltage<double> line{begin, voltage};
  const double h = voltage.duration();
  EXPECT_LT(magnitude(line(h).v - line(0).v - voltage.end().v), 1e-15);
  constexpr int parts = 100'000;
  SpaceVector<> difference_v{}, difference_a{};
  for (int n = 0; n < parts; ++n) {
    const double t = h * (n + 0.5) / parts;
    const VoltageMoments<> m = voltage(t);
    difference_v += (1.0 / parts) * (line(t).v - (begin.v + m.v));
    difference_a += (1.0 / parts) * (line(t).a - (begin.a + t * begin.v + m.a));
  }
  EXPECT_LT(magnitude(difference_v), 1e-8 * magnitude(voltage.end().v));
  EXPECT_LT(magnitude(difference_a), 1e-8 * magnitude(voltage.end().a));
}

TEST(SmoothState, IsAChangeOfVariablesAndBack) {
  const Plant plant = start(light_shaft());
  const SmoothState<Plant> smooth{plant};
  Plant::MachineState x;
  x << 1.1, -0.3, 0.9, 0.2, 40.0, 7.0;
  const VoltageMoments<> m{{0.7, -0.2}, {3e-3, 1e-3}};
  EXPECT_LT((smooth.machine(smooth.smooth(x, m), m) - x).cwiseAbs().maxCoeff(), 1e-15);
}

}  // namespace
}  // namespace sextant
