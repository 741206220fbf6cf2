// Sensors and faults as a drive reads them, beside the true state of the same plant.

#include "sextant/power_stage/sensor_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/power_stage/simulated_drive_io.hpp"
#include "sextant/run/mil_runner.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double, EnergyMeter<double>>;
using Io = SimulatedDriveIo<Plant, SegmentLog<Plant>>;

constexpr std::int32_t period_ns = 25'000;
constexpr std::int64_t at_ns = 10'010'000;  // within a period
constexpr std::int64_t end_ns = 20'000'000;

/// A fluxed machine at 60 rad/s under a turning voltage, and what is read of it.
class Bench {
 public:
  explicit Bench(const Io::Parameters& parameters)
      : load_{{.imposed_speed = ProfileParameters{.value = 60.0}}},
        plant_{DrivePlantParameters<double>{}, EnergyMeter<double>{}},
        io_{parameters, plant_, integrator_, load_} {
    EXPECT_EQ(parameters.validate(), nullptr);
    plant_.set_fluxes({0.6, 0.0}, {0.55, 0.0});
  }

  /// Calls visit(t, measurement, plant) at each period to the end.
  template <class Visit>
  void run(const Visit& visit, std::int64_t to_ns = end_ns) {
    for (; t_ns_ <= to_ns; t_ns_ += period_ns) {
      const Measurement<double> m = io_.read(t_ns_);
      visit(t_ns_, m, io_.plant());
      const auto n = std::size_t(t_ns_ / period_ns);
      const SwitchState state = n % 2 == 0 ? switch_states[1 + n / 80 % 6] : switch_states[0];
      GatePattern pattern{state, 15'000};
      pattern.append({state, 10'000});
      io_.write(pattern);
    }
  }
  [[nodiscard]] Io& io() { return io_; }

 private:
  MechanicalLoad load_;
  Plant plant_;
  FixedStepIntegrator<Plant> integrator_{};
  Io io_;
  std::int64_t t_ns_{};
};

Io::Parameters with(const SensorParameters& sensors) {
  Io::Parameters p;
  p.sensors = sensors;
  return p;
}

Io::Parameters with(const PlantFaultParameters& fault) {
  Io::Parameters p;
  p.measures_angle = true;
  p.fault = fault;
  return p;
}

double phase(const ThreePhase<double>& x, std::size_t n) {
  return std::array{x.a, x.b, x.c}[n];
}

/// Reads with the fault in phase b, which begins at at_ns; visit(t, m, plant) from then on, before it the
/// readings must be true.
void with_fault(PlantFaultParameters fault,
                const std::function<void(std::int64_t, const Measurement<double>&, const Plant&)>& visit) {
  fault.phase = 1;
  fault.at_ns = at_ns;
  Bench bench{with(fault)};
  bench.run([&](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
    if (t_ns >= at_ns) return visit(t_ns, m, plant);
    ASSERT_EQ(m.i_abc, plant.i_abc());
    ASSERT_EQ(m.omega_m, plant.omega_m());
    ASSERT_EQ(m.u_dc, 530.0);
  });
}

TEST(Sensors, IdealOnesReadTheTrueStateBitByBit) {
  Io::Parameters neutral;
  neutral.measures_angle = true;
  neutral.sensors.seed = 99;
  neutral.sensors.encoder.window_periods = 7;
  neutral.fault = {.phase = 2, .at_ns = 1, .drift = 5, .jump = 3, .sag_voltage = 10};
  Bench bench{neutral};
  int reads = 0;
  bench.run([&](std::int64_t, const Measurement<double>& m, const Plant& plant) {
    ASSERT_EQ(m.i_abc, plant.i_abc());
    ASSERT_EQ(m.u_dc, 530.0);
    ASSERT_EQ(m.omega_m, plant.omega_m());
    ASSERT_EQ(m.theta_m, std::remainder(plant.theta_m(), 2 * std::numbers::pi));
    ++reads;
  });
  EXPECT_EQ(reads, 801);
}

TEST(Sensors, ADriveWithIdealOnesRunsAsOneWithout) {
  RigParameters neutral;
  neutral.stage.io.sensors.seed = 99;
  neutral.stage.io.fault = {.phase = 2, .at_ns = 1, .drift = 5};
  DriveRig without;
  DriveRig with_neutral{neutral};
  for (DriveRig* rig : {&without, &with_neutral}) {
    rig->start();
    rig->torque = 15.0;
    rig->run(0.1);
  }
  EXPECT_GT(without.plant().tau_e(), 5.0);
  EXPECT_EQ(without.plant().state(), with_neutral.plant().state());
}

TEST(Sensors, GainAndOffsetArePerPhase) {
  SensorParameters s;
  s.current.gain_error = 0.01;
  s.phases[0] = {.gain_error = -0.03, .offset = 0.5};
  s.phases[2] = {.gain_error = 0.0, .offset = -0.25};
  s.voltage = {.gain_error = -0.02, .offset = 3.0};
  Bench bench{with(s)};
  bench.run([](std::int64_t, const Measurement<double>& m, const Plant& plant) {
    const ThreePhase<double> i = plant.i_abc();
    ASSERT_NEAR(m.i_abc.a, 0.98 * i.a + 0.5, 1e-12 * (1 + std::abs(i.a)));
    ASSERT_NEAR(m.i_abc.b, 1.01 * i.b, 1e-12 * (1 + std::abs(i.b)));
    ASSERT_NEAR(m.i_abc.c, 1.01 * i.c - 0.25, 1e-12 * (1 + std::abs(i.c)));
    ASSERT_NEAR(m.u_dc, 0.98 * 530.0 + 3.0, 1e-12 * 530);
    ASSERT_EQ(m.omega_m, plant.omega_m());
  });
}

TEST(Sensors, TheLinkVoltageIsNeverReadBelowZero) {
  SensorParameters s;
  s.voltage = {.offset = -700.0, .range = 1000.0, .bits = 10};
  Bench bench{with(s)};
  bench.run([](std::int64_t, const Measurement<double>& m, const Plant&) { ASSERT_EQ(m.u_dc, 0.0); });
}

TEST(Sensors, TheNoiseOfEachIsItsOwn) {
  SensorParameters s;
  s.current.noise = 0.2;
  s.voltage.noise = 1.5;
  s.seed = 12;
  SCOPED_TRACE(s.seed);
  std::array<double, 4> square{};
  double product = 0, previous = 0, lagged = 0;
  int n = 0;
  Bench bench{with(s)};
  bench.run(
      [&](std::int64_t, const Measurement<double>& m, const Plant& plant) {
        std::array<double, 4> e{};
        for (std::size_t x = 0; x < 3; ++x) e[x] = phase(m.i_abc, x) - phase(plant.i_abc(), x);
        e[3] = m.u_dc - 530.0;
        for (std::size_t x = 0; x < 4; ++x) square[x] += e[x] * e[x];
        product += e[0] * e[1];
        lagged += e[0] * previous;
        previous = e[0];
        ++n;
      },
      500'000'000);
  const double spread = 6.0 / std::sqrt(2.0 * n);
  for (std::size_t x = 0; x < 3; ++x) EXPECT_NEAR(std::sqrt(square[x] / n), 0.2, 0.2 * spread);
  EXPECT_NEAR(std::sqrt(square[3] / n), 1.5, 1.5 * spread);
  EXPECT_NEAR(product / n, 0.0, 0.04 * 6.0 / std::sqrt(n));
  EXPECT_NEAR(lagged / n, 0.0, 0.04 * 6.0 / std::sqrt(n));
}

TEST(Sensors, NoiseIsRepeatedBySeed) {
  const auto readings = [](std::uint64_t seed) {
    SensorParameters s;
    s.current.noise = 0.2;
    s.seed = seed;
    std::vector<double> list;
    Bench bench{with(s)};
    bench.run(
        [&list](std::int64_t, const Measurement<double>& m, const Plant&) { list.push_back(m.i_abc.a); });
    return list;
  };
  EXPECT_EQ(readings(3), readings(3));
  EXPECT_NE(readings(3), readings(4));
}

TEST(Sensors, TwelveBitsRoundAndSaturate) {
  SensorParameters s;
  s.current.range = 20.0;
  s.current.bits = 12;
  constexpr double step = 40.0 / 4096;
  bool saturated = false;
  Bench bench{with(s)};
  bench.run([&](std::int64_t, const Measurement<double>& m, const Plant& plant) {
    for (std::size_t x = 0; x < 3; ++x) {
      const double i = phase(m.i_abc, x);
      const double expected = std::clamp(phase(plant.i_abc(), x), -20.0, 20.0 - step);
      ASSERT_LE(std::abs(i - expected), 0.5 * step * (1 + 1e-9));
      ASSERT_EQ(i / step, std::round(i / step));
      saturated = saturated || std::abs(phase(plant.i_abc(), x)) > 21.0;
    }
  });
  EXPECT_TRUE(saturated);
}

// The bench's patterns have a boundary 10 µs before the next period; the log has the state there.
TEST(Sensors, CurrentsAreSampledAheadOfThePeriod) {
  SensorParameters s;
  s.sampling_lead_ns = 10'000;
  Bench bench{with(s)};
  double moved = 0;
  bench.run([&](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
    if (t_ns == 0) return;
    const auto segments = bench.io().log().segments();
    ASSERT_EQ(segments.size(), 2U);
    const Plant::State& x = bench.io().log().instants()[segments[1].begin];
    const SpaceVector<double> i = plant.machine().stator_current({x[0], x[1]}, {x[2], x[3]});
    ASSERT_EQ(m.i_abc, inverse_clarke(i));
    ASSERT_EQ(m.omega_m, plant.omega_m());
    moved = std::max(moved, std::abs(m.i_abc.a - plant.i_abc().a));
  });
  EXPECT_GT(moved, 0.2) << "10 µs of an active vector";
}

TEST(Sensors, ASamplingLeadLongerThanTheTimeSinceTheLastReadGivesTheStateThen) {
  SensorParameters s;
  s.sampling_lead_ns = 20'000;
  Bench bench{with(s)};
  ThreePhase<double> before{};
  bench.run([&](std::int64_t, const Measurement<double>&, const Plant& plant) { before = plant.i_abc(); },
            1'000'000);
  EXPECT_EQ(bench.io().read(1'000'000 + 5'000).i_abc, before);
}

TEST(Sensors, TheEncoderQuantisesAngleAndSpeed) {
  Io::Parameters p = with(SensorParameters{.encoder = {.lines = 500, .window_periods = 40}});
  p.measures_angle = true;
  const double edge = 2 * std::numbers::pi / 2000;
  Bench bench{p};
  bench.run([&](std::int64_t, const Measurement<double>& m, const Plant& plant) {
    ASSERT_TRUE(m.theta_m.has_value());
    const double lag = std::remainder(plant.theta_m() - *m.theta_m, 2 * std::numbers::pi);
    ASSERT_GT(lag, -1e-9);
    ASSERT_LT(lag, edge + 1e-9);
    ASSERT_NEAR(std::remainder(*m.theta_m, edge), 0.0, 1e-12);
    ASSERT_EQ(m.i_abc, plant.i_abc());
    ASSERT_NEAR(m.omega_m, 60.0, edge / 1e-3 * (1 + 1e-9));
    ASSERT_NEAR(std::remainder(m.omega_m, edge / 1e-3), 0.0, 1e-9);
  });
}

// Without a past the second edge makes the first speed, of 40 rad/s, when the gates are already driven.
TEST(Sensors, WithEitherSpeedOfTheEncoderTheDriveStartsOnATurningShaft) {
  for (const EncoderSpeed speed : {EncoderSpeed::count, EncoderSpeed::period}) {
    for (const double omega_m : {40.0, -40.0}) {
      SCOPED_TRACE(omega_m);
      RigParameters p = RigParameters::at_speed(omega_m);
      p.stage.io.sensors.encoder = {.lines = 128, .speed = speed, .window_periods = 20};
      DriveRig rig{p};
      rig.start();
      rig.run(0.1);
      EXPECT_EQ(rig.drive().state(), DriveState::torque);
      EXPECT_FALSE(rig.telemetry.latched.any());
    }
  }
}

TEST(PlantFaults, AStuckCurrentKeepsItsLastReading) {
  // The last read before the fault.
  double last = 0;
  Bench truth{Io::Parameters{}};
  truth.run([&last](std::int64_t t_ns, const Measurement<double>& m, const Plant&) {
    if (t_ns < at_ns) last = m.i_abc.b;
  });
  ASSERT_GT(std::abs(last), 1.0);
  with_fault({.kind = PlantFaultKind::current_stuck},
             [last](std::int64_t, const Measurement<double>& m, const Plant& plant) {
               ASSERT_EQ(m.i_abc.b, last);
               ASSERT_EQ(m.i_abc.a, plant.i_abc().a);
               ASSERT_EQ(m.i_abc.c, plant.i_abc().c);
             });
}

TEST(PlantFaults, ACurrentReadsZero) {
  with_fault({.kind = PlantFaultKind::current_zero},
             [](std::int64_t, const Measurement<double>& m, const Plant& plant) {
               ASSERT_EQ(m.i_abc, (ThreePhase<double>{plant.i_abc().a, 0.0, plant.i_abc().c}));
             });
}

TEST(PlantFaults, ACurrentDrifts) {
  with_fault({.kind = PlantFaultKind::current_drift, .drift = -200.0},
             [](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
               ASSERT_NEAR(m.i_abc.b, plant.i_abc().b - 200.0 * double(t_ns - at_ns) * 1e-9, 1e-9);
               ASSERT_EQ(m.i_abc.a, plant.i_abc().a);
             });
}

TEST(PlantFaults, ADriftSaturatesAtTheSensorsRange) {
  Io::Parameters p = with({.kind = PlantFaultKind::current_drift, .drift = 1e5});
  p.sensors.current.range = 50.0;
  double last = 0;
  Bench bench{p};
  bench.run([&last](std::int64_t, const Measurement<double>& m, const Plant&) { last = m.i_abc.a; });
  EXPECT_EQ(last, 50.0);
}

TEST(PlantFaults, TwoPhasesAreSwapped) {
  with_fault({.kind = PlantFaultKind::phases_swapped},
             [](std::int64_t, const Measurement<double>& m, const Plant& plant) {
               const ThreePhase<double> i = plant.i_abc();
               ASSERT_EQ(m.i_abc, (ThreePhase<double>{i.a, i.c, i.b}));
             });
}

TEST(PlantFaults, TheSpeedIsLostFrozenOrJumps) {
  with_fault({.kind = PlantFaultKind::speed_lost},
             [](std::int64_t, const Measurement<double>& m, const Plant&) { ASSERT_EQ(m.omega_m, 0.0); });
  double angle = 0;
  with_fault({.kind = PlantFaultKind::speed_frozen},
             [&angle](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
               ASSERT_EQ(m.omega_m, 60.0);
               if (t_ns - at_ns < period_ns) angle = *m.theta_m;
               ASSERT_EQ(m.theta_m, angle);
               ASSERT_NE(std::remainder(plant.theta_m(), 2 * std::numbers::pi), angle);
             });
  with_fault({.kind = PlantFaultKind::encoder_reversed},
             [](std::int64_t, const Measurement<double>& m, const Plant& plant) {
               ASSERT_EQ(m.omega_m, -plant.omega_m());
               ASSERT_EQ(*m.theta_m, -std::remainder(plant.theta_m(), 2 * std::numbers::pi));
             });
  with_fault({.kind = PlantFaultKind::speed_jump, .jump = -35.0},
             [](std::int64_t, const Measurement<double>& m, const Plant& plant) {
               ASSERT_EQ(m.omega_m, plant.omega_m() - 35.0);
             });
}

TEST(PlantFaults, AFrozenSpeedDoesNotFollowTheShaft) {
  MechanicalLoad load{{.imposed_speed = ProfileParameters{.shape = ProfileShape::linear,
                                                          .points = {{0.0, 0.0}, {1.0, 1000.0}}}}};
  Plant plant{DrivePlantParameters<double>{}, EnergyMeter<double>{}};
  FixedStepIntegrator<Plant> integrator;
  Io io{with({.kind = PlantFaultKind::speed_frozen, .at_ns = at_ns}), plant, integrator, load};
  for (std::int64_t t = 0; t <= end_ns; t += period_ns) {
    const double expected = 1e-6 * double(std::min(t, at_ns / period_ns * period_ns));
    ASSERT_NEAR(io.read(t).omega_m, expected, 1e-9);
  }
}

TEST(PlantFaults, TheLinksReadingSticksWhileTheLinkDoesNot) {
  Io::Parameters p = with({.kind = PlantFaultKind::link_stuck, .at_ns = at_ns});
  p.sensors.voltage.noise = 2.0;
  double last = 0;
  Bench bench{p};
  bench.run([&last](std::int64_t t_ns, const Measurement<double>& m, const Plant&) {
    if (t_ns >= at_ns) {
      ASSERT_EQ(m.u_dc, last);
    } else {
      ASSERT_NE(m.u_dc, last);
    }
    last = m.u_dc;
  });
}

TEST(PlantFaults, TheLinkItselfSags) {
  for (const std::int64_t ramp_ns : {std::int64_t{0}, std::int64_t{4'000'000}}) {
    SCOPED_TRACE(ramp_ns);
    with_fault({.kind = PlantFaultKind::link_sag, .sag_voltage = 200.0, .ramp_ns = ramp_ns},
               [ramp_ns](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
                 const double share =
                     ramp_ns == 0 ? 1.0 : std::min(1.0, double(t_ns - at_ns) / double(ramp_ns));
                 const double link = 530.0 + share * (200.0 - 530.0);
                 ASSERT_NEAR(m.u_dc, link, 1e-9);
                 // The plant's is the mean over the last stretch.
                 const double half_period = ramp_ns == 0 ? 0.0 : 330.0 * 12.5e3 / double(ramp_ns);
                 ASSERT_NEAR(plant.inputs().u_dc, link, half_period * 1.001 + 1e-9);
                 ASSERT_EQ(m.i_abc, plant.i_abc());
               });
  }
}

// The volt-seconds of a period in which the link falls are those of both voltages.
TEST(PlantFaults, TheSagActsAtItsInstant) {
  const auto flux_at_end = [](const PlantFaultParameters& fault) {
    MechanicalLoad load{{.imposed_speed = ProfileParameters{}}};
    DrivePlantParameters<double> p;
    Plant plant{p, EnergyMeter<double>{}};
    FixedStepIntegrator<Plant> integrator;
    Io io{with(fault), plant, integrator, load};
    static_cast<void>(io.read(0));
    io.write({switch_states[1], period_ns});
    static_cast<void>(io.read(period_ns));
    return plant.psi_s().alpha;
  };
  const double whole = flux_at_end({});
  const double sagged = flux_at_end({.kind = PlantFaultKind::link_sag, .at_ns = 15'000, .sag_voltage = 30.0});
  EXPECT_NEAR(whole - sagged, 2.0 / 3.0 * 500.0 * 10e-6, 1e-5);  // and R i
  const double ramped =
      flux_at_end({.kind = PlantFaultKind::link_sag, .sag_voltage = 30.0, .ramp_ns = period_ns});
  EXPECT_NEAR(whole - ramped, 2.0 / 3.0 * 250.0 * 25e-6, 1e-5);
}

TEST(PlantFaults, AnOpenPhaseHasNoCurrent) {
  std::int64_t open_ns = 0;
  with_fault({.kind = PlantFaultKind::open_phase},
             [&open_ns](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
               ASSERT_EQ(m.i_abc, plant.i_abc());
               if (open_ns == 0 && std::abs(m.i_abc.b) < 1e-7) open_ns = t_ns;
               if (open_ns == 0) return;
               ASSERT_NEAR(m.i_abc.b, 0.0, 1e-7);
               ASSERT_NEAR(m.i_abc.a, -m.i_abc.c, 1e-7);
             });
  EXPECT_GT(open_ns, at_ns);
  EXPECT_LT(open_ns, end_ns - 1'000'000);
}

// The field of the inverter turns the other way in the machine: with the shaft reversed as well the readings
// are those of a machine with its cables right.
TEST(PlantFaults, SwappedCablesMirrorTheMachine) {
  for (const int phase : {0, 1, 2}) {
    SCOPED_TRACE(phase);
    const auto run = [phase](PlantFaultKind kind, double omega_m) {
      Io::Parameters p;
      p.fault = {.kind = kind, .phase = phase};
      MechanicalLoad load{{.imposed_speed = ProfileParameters{.value = omega_m}}};
      Plant plant{DrivePlantParameters<double>{}, EnergyMeter<double>{}};
      ExactIntegrator<Plant> integrator;
      Io io{p, plant, integrator, load};
      Measurement<double> m;
      for (int k = 0; k < 400; ++k) {
        m = io.read(std::int64_t{k} * period_ns);
        io.write({switch_states[std::size_t(1 + k / 60 % 6)], period_ns});
      }
      return std::pair{m, plant.tau_e()};
    };
    const auto [right, torque] = run(PlantFaultKind::none, 60.0);
    const auto [swapped, mirrored] = run(PlantFaultKind::cables_swapped, -60.0);
    EXPECT_NEAR(swapped.i_abc.a, right.i_abc.a, 1e-6);
    EXPECT_NEAR(swapped.i_abc.b, right.i_abc.b, 1e-6);
    EXPECT_NEAR(swapped.i_abc.c, right.i_abc.c, 1e-6);
    EXPECT_EQ(swapped.applied, right.applied);
    EXPECT_NEAR(mirrored, -torque, 1e-6);
    EXPECT_GT(std::abs(torque), 1.0);
  }
}

TEST(PlantFaults, EndsAtItsTime) {
  for (const PlantFaultKind kind : {PlantFaultKind::current_zero, PlantFaultKind::open_phase,
                                    PlantFaultKind::speed_lost, PlantFaultKind::link_sag}) {
    SCOPED_TRACE(int(kind));
    Bench bench{with({.kind = kind, .phase = 0, .at_ns = 2'000'000, .until_ns = 8'000'000})};
    bench.run([](std::int64_t t_ns, const Measurement<double>& m, const Plant& plant) {
      if (t_ns < 8'000'000) return;
      ASSERT_EQ(m.i_abc, plant.i_abc());
      ASSERT_EQ(m.omega_m, 60.0);
      ASSERT_EQ(m.u_dc, 530.0);
      ASSERT_FALSE(plant.has_events());
    });
    EXPECT_GT(std::abs(bench.io().plant().i_abc().a), 1e-3);
  }
}

TEST(PlantFaults, CountFromTheLoadsOrigin) {
  constexpr std::int64_t uptime_ns = 400'000'000'000'000;
  Io::Parameters p = with({.kind = PlantFaultKind::speed_lost, .at_ns = 100'000});
  p.load_origin_ns.reset();
  MechanicalLoad load{{.imposed_speed = ProfileParameters{.value = 10.0}}};
  Plant plant{DrivePlantParameters<double>{}, EnergyMeter<double>{}};
  FixedStepIntegrator<Plant> integrator;
  Io io{p, plant, integrator, load};
  for (std::int64_t k = 0; k < 10; ++k)
    EXPECT_EQ(io.read(uptime_ns + k * period_ns).omega_m, k < 4 ? 10.0 : 0.0) << k;
}

// The whole drive, which does not know: its energy is accounted for all the same.
TEST(PlantFaults, AScenarioWithThemKeepsItsBalanceOfEnergy) {
  for (const IntegratorKind integrator :
       {IntegratorKind::cvode, IntegratorKind::fixed, IntegratorKind::exact, IntegratorKind::erk}) {
    for (const PlantFaultKind kind : {PlantFaultKind::open_phase, PlantFaultKind::link_sag}) {
      SCOPED_TRACE(std::to_string(int(integrator)) + ", fault " + std::to_string(int(kind)));
      RigParameters p = RigParameters::at_speed(30.0, integrator);
      p.stage.io.fault = {.kind = kind, .phase = 2, .at_ns = 100'000'000, .ramp_ns = 10'000'000};
      p.stage.io.sensors.current = {.noise = 0.1, .range = 400, .bits = 12};
      MeteredPowerStage stage{p.stage, p.load};
      DirectTorqueController<double> controller{p.controller};
      Drive<double> drive{p.drive, controller};
      Scenario scenario;
      scenario.name = "fault";
      scenario.duration_ns = 200'000'000;
      scenario.torque_reference.value = 15.0;
      const MilResult result =
          MilRunner{drive, stage.io(), period_ns, &controller}.run(scenario, nullptr, {});
      EXPECT_TRUE(result.plant_healthy);
      EXPECT_LT(result.metrics[Metric::energy_unaccounted], 1e-6);
      EXPECT_EQ(std::abs(stage.io().plant().i_abc().c) < 1e-7, kind == PlantFaultKind::open_phase);
    }
  }
}

TEST(Sensors, WhatIsNotANumberIsReadAsSuch) {
  SensorParameters s;
  s.current = {.noise = 0.1, .range = 100, .bits = 12};
  s.encoder.lines = 100;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  SensorModel model{s, {}};
  Measurement<double> m{.i_abc = {nan, 1.0, -1.0}, .u_dc = 530.0, .omega_m = nan};
  model.step(m, nan, 0, 0);
  EXPECT_TRUE(std::isnan(m.i_abc.a));
  EXPECT_TRUE(std::isnan(m.omega_m));
  EXPECT_TRUE(std::isfinite(m.i_abc.b));
}

TEST(Sensors, ParametersAreChecked) {
  EXPECT_EQ(Io::Parameters{}.validate(), nullptr);
  SensorParameters s;
  s.phases[1].gain_error = -1.5;
  EXPECT_NE(with(s).validate(), nullptr);
  s = {};
  s.voltage.bits = 12;
  EXPECT_NE(with(s).validate(), nullptr);
  s = {};
  s.encoder.lines = -1;
  EXPECT_NE(with(s).validate(), nullptr);
  s = {};
  s.sampling_lead_ns = -1;
  EXPECT_NE(with(s).validate(), nullptr);
  s.sampling_lead_ns = period_ns + 1;
  EXPECT_NE(with(s).validate(), nullptr);
  s.sampling_lead_ns = period_ns;
  EXPECT_EQ(with(s).validate(), nullptr);
  EXPECT_NE(with(PlantFaultParameters{.phase = 3}).validate(), nullptr);
  EXPECT_NE(with(PlantFaultParameters{.at_ns = 5, .until_ns = 5}).validate(), nullptr);
  EXPECT_NE(with(PlantFaultParameters{.sag_voltage = 0.0}).validate(), nullptr);
  EXPECT_NE(with(PlantFaultParameters{.ramp_ns = -1}).validate(), nullptr);
}

}  // namespace
}  // namespace sextant
