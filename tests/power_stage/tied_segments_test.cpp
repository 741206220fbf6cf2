// A fixed step that goes over dead times and drops (`TiedSegments`) against CVODE with restarts at each
// switching and at each zero of a current.
#include "sextant/plant/tied_segments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

constexpr double u_dc = 530.0;
constexpr auto low = LegState::low;
constexpr auto high = LegState::high;
constexpr auto off = LegState::off;

/// What of the inverter and of the machine is not ideal.
struct Effects {
  std::int32_t period_ns{25'000};
  std::int32_t dead_time_ns{0};
  bool drops{false};
  bool saturation{false};
  bool iron_loss{false};
};

DrivePlantParameters<double> plant_with(const Effects& effects) {
  DrivePlantParameters<double> p;
  if (effects.drops) p.drops = {.threshold_voltage = 1.2, .slope_resistance = 0.02};
  if (effects.saturation) p.saturation = {.knee = 1.1, .machine_flux = 1.1};
  if (effects.iron_loss) {
    p.iron_loss.eddy_resistance = 1000.0;
    p.iron_loss.hysteresis_resistance = 1000.0;
  }
  return p;
}

/// Centred pulses for a voltage of the given share of u_dc/√3 and angle [rad], each leg shifted by up to a
/// tenth of the period, as no modulator does it.
GatePattern pulses(double share, double angle, std::int32_t period_ns, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-0.05, 0.05);
  std::array<std::int32_t, 3> on{}, until{};
  std::vector<std::int32_t> edges{0, period_ns};
  for (std::size_t x = 0; x < 3; ++x) {
    const double width = 0.5 + 0.5 * share * std::cos(angle - double(x) * 2.0 * std::numbers::pi / 3.0);
    const double middle = 0.5 + shift(random);
    on[x] = std::int32_t(double(period_ns) * std::clamp(middle - 0.5 * width, 0.02, 0.98));
    until[x] = std::int32_t(double(period_ns) * std::clamp(middle + 0.5 * width, 0.02, 0.98));
    edges.push_back(on[x]);
    edges.push_back(until[x]);
  }
  std::ranges::sort(edges);
  GatePattern pattern;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    if (edges[k + 1] == edges[k]) continue;
    const auto leg = [&](std::size_t x) { return edges[k] >= on[x] && edges[k] < until[x] ? high : low; };
    EXPECT_TRUE(pattern.append({{leg(0), leg(1), leg(2)}, edges[k + 1] - edges[k]}));
  }
  return pattern;
}

/// A machine whose evaluations are counted.
class CountingMachine : public InductionMachine<double> {
 public:
  using InductionMachine<double>::InductionMachine;
  [[nodiscard]] MachineEvaluation<> evaluate(const FluxPair<>& psi, SpaceVector<> u_s,
                                             double omega_m) const noexcept {
    ++evaluations;
    return InductionMachine<double>::evaluate(psi, u_s, omega_m);
  }
  static inline std::int64_t evaluations{0};
};

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;

struct Course {
  std::vector<double> torque;  ///< at the end of each period [N·m]
  double unaccounted{};        ///< energy, by what was drawn from the link; 0 without a meter [-]
};

/// The machine under a voltage that turns, from a flux that it keeps, at the speed of 5 rad/s of slip.
template <class Plant>
Course run(const Effects& effects, PlantIntegrator<Plant>& integrator, double frequency, int periods) {
  const DrivePlantParameters<double> parameters = plant_with(effects);
  const InductionMachineParameters<double>& m = parameters.machine;
  Plant plant{parameters};
  const double omega_m = (frequency - 5.0) / m.pole_pairs;
  const MechanicalLoad load{{.imposed_speed = ProfileParameters{.value = omega_m}}};
  SimulatedDriveIoParameters io{.period_ns = effects.period_ns, .u_dc = u_dc};
  io.dead_time_ns = effects.dead_time_ns;
  SimulatedDriveIo<Plant, SegmentLog<Plant>> stage{io, plant, integrator, load};
  EXPECT_TRUE(stage.read(0).plausible);
  plant.set_fluxes({1.0, 0.0}, {0.9, -0.1});
  const double stored = plant.magnetic_energy();
  std::mt19937 random{20250};  // NOLINT(cert-msc51-cpp): the same patterns in each run
  Course result;
  const double share = (frequency * 1.0 + 15.0) / (u_dc / 2.0);
  for (int n = 0; n < periods; ++n) {
    const double t = 1e-9 * double(effects.period_ns) * (n + 0.5);
    stage.write(pulses(share, frequency * t + std::numbers::pi / 2.0, effects.period_ns, random));
    EXPECT_TRUE(stage.read(std::int64_t{n + 1} * effects.period_ns).plausible);
    result.torque.push_back(plant.tau_e());
  }
  if constexpr (has_part<Meter, typename Plant::AppendedType>) {
    const auto energy = Plant::template states_of<Meter>(plant.state());
    const double spent = energy[Meter::stator_copper] + energy[Meter::rotor_copper] + energy[Meter::iron] +
                         energy[Meter::mechanical] + plant.magnetic_energy() - stored;
    result.unaccounted = std::abs(energy[Meter::dc_link] - spent) / std::abs(spent);
  }
  return result;
}

Course by_cvode(const Effects& effects, double frequency, int periods) {
  CvodeParameters tight{};
  tight.relative_tolerance = 1e-12;
  tight.flux_tolerance = 1e-14;
  tight.at_switching = AtSwitching::stop;
  CvodeIntegrator<Plant> cvode{tight};
  return run<Plant>(effects, cvode, frequency, periods);
}

double largest_error(const std::vector<double>& a, const std::vector<double>& of) {
  double error = 0, peak = 0;
  for (std::size_t k = 0; k < of.size(); ++k) {
    error = std::max(error, std::abs(a[k] - of[k]));
    peak = std::max(peak, std::abs(of[k]));
  }
  return error / peak;
}

constexpr std::array<Effects, 6> cases{{{25'000, 1'500},
                                        {25'000, 0, true},
                                        {25'000, 1'500, true},
                                        {25'000, 1'500, true, true, true},
                                        {125'000, 3'000},
                                        {125'000, 3'000, true, true, true}}};

TEST(TiedSegments, MoveThePlantAsCvodeDoesThatStopsAtEachEdge) {
  for (const Effects& effects : cases) {
    for (const double frequency : {20.0, 300.0}) {
      SCOPED_TRACE(testing::Message() << effects.period_ns << " ns, dead time " << effects.dead_time_ns
                                      << " ns, drops " << effects.drops << ", saturation "
                                      << effects.saturation << ", at " << frequency << " rad/s");
      const int periods = 30'000'000 / effects.period_ns;
      FixedStepIntegrator<Plant> fixed;
      const Course over = run<Plant>(effects, fixed, frequency, periods);
      const Course exact = by_cvode(effects, frequency, periods);
      EXPECT_LT(largest_error(over.torque, exact.torque), 1e-5);
      EXPECT_LT(over.unaccounted, 1e-5);
    }
  }
}

TEST(TiedSegments, TakeFewerEvaluationsThanStopsAtEachEdge) {
  for (const Effects& effects : {cases[0], cases[1], cases[4]}) {
    // A meter evaluates the machine at each corner, whose slopes it does not use.
    using Counting = DrivePlant<double, NoAppendedSystem<double>, CountingMachine>;
    const auto evaluations = [&effects](AtSwitching at_switching) {
      FixedStepIntegrator<Counting> fixed{{.at_switching = at_switching}};
      CountingMachine::evaluations = 0;
      static_cast<void>(run<Counting>(effects, fixed, 100.0, 200));
      return CountingMachine::evaluations;
    };
    EXPECT_LT(double(evaluations(AtSwitching::go_on)), 0.6 * double(evaluations(AtSwitching::stop)));
  }
}

/// A plant with these phase currents and no rotor current, at standstill.
Plant with_currents(const Effects& effects, const ThreePhase<>& i) {
  const DrivePlantParameters<double> parameters = plant_with(effects);
  Plant plant{parameters, EnergyMeter<double>{}};
  PlantInputs<double> inputs;
  inputs.u_dc = u_dc;
  inputs.imposed_speed = true;
  plant.set_inputs(inputs);
  plant.set_fluxes(parameters.machine.l_s() * clarke(i), parameters.machine.l_m * clarke(i));
  return plant;
}

TEST(TiedSegments, TieALegThatIsOffByTheSignOfItsCurrent) {
  const Plant plant = with_currents({}, {20.0, -8.0, -12.0});
  const std::array<GateSegment, 2> acted{{{{off, off, high}, 1'000}, {{low, high, off}, 2'000}}};
  const TiedSegments<Plant> tied{plant, acted};
  ASSERT_EQ(tied.segments().size(), 2U);
  EXPECT_EQ(tied.segments()[0].state, (SwitchState{low, high, high}));
  EXPECT_EQ(tied.segments()[1].state, (SwitchState{low, high, high}));
  EXPECT_EQ(tied.segments()[1].duration_ns, 2'000);
}

TEST(TiedSegments, HoldWhileTheCurrentsThatCountKeepTheirSigns) {
  const ThreePhase<> i{20.0, -8.0, -12.0};
  const std::array<GateSegment, 3> acted{
      {{{low, high, high}, 5'000}, {{low, off, high}, 1'000}, {{low, low, high}, 5'000}}};
  const auto corners = [](const ThreePhase<>& first, const ThreePhase<>& second, const ThreePhase<>& third) {
    return std::array{with_currents({}, first).state(), with_currents({}, second).state(),
                      with_currents({}, third).state()};
  };
  const ThreePhase<> reversed{20.0, 1.0, -21.0};
  Effects lossy;
  lossy.drops = true;
  for (const bool has_drops : {false, true}) {
    SCOPED_TRACE(has_drops ? "drops" : "no drops");
    const Plant plant = with_currents(has_drops ? lossy : Effects{}, i);
    const TiedSegments<Plant> tied{plant, acted};
    EXPECT_TRUE(tied.hold(corners(i, i, i)));
    EXPECT_FALSE(tied.hold(corners(reversed, i, i)));
    EXPECT_FALSE(tied.hold(corners(i, reversed, i)));
    // A leg that is driven carries either current, unless a threshold takes the voltage of the other one.
    EXPECT_EQ(tied.hold(corners(i, i, reversed)), !has_drops);
  }
}

// A current may bend to zero between two ends at which it has its sign.
TEST(TiedSegments, DoNotHoldWhereACurrentIsNearerToZeroThanItMayBendWithinASegment) {
  const ThreePhase<> i{20.0, -0.01, -19.99};
  const Plant plant = with_currents({}, i);
  for (const std::int32_t duration_ns : {100, 100'000}) {
    SCOPED_TRACE(testing::Message() << duration_ns << " ns");
    const std::array<GateSegment, 2> acted{
        {{{low, off, high}, duration_ns}, {{low, high, high}, duration_ns}}};
    const std::array corners{plant.state(), plant.state()};
    EXPECT_EQ(TiedSegments<Plant>(plant, acted).hold(corners), duration_ns == 100);
  }
}

}  // namespace
}  // namespace sextant
