#include "sextant/safety/torque_monitor.hpp"

#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "safety/steady_machine.hpp"

namespace sextant {
namespace {

constexpr double psi_r = 1.0;  // [Wb]

/// A monitor on a machine in steady state.
template <class T>
class Watched {
 public:
  using Limits = TorqueMonitorLimits<T>;

  explicit Watched(const Limits& limits = {}) : monitor{limits} {}

  /// Runs for a time; true when a fault was present at its end. `commanded` empty: no torque production.
  bool run(const SteadyMachine& machine, double seconds, std::optional<double> commanded) {
    bool fault = false;
    const std::optional<T> command = commanded ? std::optional<T>{T(*commanded)} : std::nullopt;
    for (std::int64_t end = n + std::llround(seconds / SteadyMachine::dt); n < end;) {
      fault = monitor.step(machine.measurement<T>(++n), T(SteadyMachine::dt), command);
    }
    return fault;
  }
  /// Time until the fault, up to 0.1 s. [s]
  double time_to_fault(const SteadyMachine& machine, double commanded) {
    const std::int64_t begin = n;
    while (n - begin < 4000 && !run(machine, SteadyMachine::dt, commanded)) {
    }
    return double(n - begin) * SteadyMachine::dt;
  }
  /// The flux of the monitor follows that of the machine after some rotor time constants.
  void settle(const SteadyMachine& machine) { (void)run(machine, 1.2, machine.torque()); }

  TorqueMonitor<T> monitor;
  std::int64_t n{0};
};

template <class T>
class TorqueMonitorOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueMonitorOf, Scalars);

SteadyMachine at(double omega_m, double torque, const InductionMachineParameters<double>& machine = {}) {
  return SteadyMachine::of_torque(machine, psi_r, omega_m, torque);
}

TYPED_TEST(TorqueMonitorOf, BothMethodsFindTheTorqueOfASteadyState) {
  for (const double omega_m : {-300.0, -60.0, 20.0, 100.0, 400.0}) {
    for (const double torque : {-130.0, -15.0, 2.0, 60.0}) {
      SCOPED_TRACE(std::to_string(omega_m) + " rad/s, " + std::to_string(torque) + " N·m");
      const SteadyMachine machine = at(omega_m, torque);
      Watched<TypeParam> watched;
      watched.settle(machine);
      const TorqueBands<TypeParam>& bands = watched.monitor.bands();
      ASSERT_TRUE(bands.has_power());
      const double tolerance = 0.003 * std::abs(torque) + 0.02;
      EXPECT_NEAR(double(bands.by_current().torque), torque, tolerance);
      EXPECT_NEAR(double(bands.by_power().torque), torque, tolerance);
    }
  }
}

TYPED_TEST(TorqueMonitorOf, NearZeroStatorFrequencyTheCurrentsCountAndElsewhereThePower) {
  for (const double torque : {-60.0, 15.0, 130.0}) {
    SCOPED_TRACE(torque);
    Watched<TypeParam> slow;
    const double slip = at(0.0, torque).omega_e();
    slow.settle(at(-0.45 * slip, torque));  // ω_e is a tenth of the slip
    EXPECT_EQ(slow.monitor.torque(), slow.monitor.bands().by_current().torque);
    Watched<TypeParam> fast;
    fast.settle(at(100.0, torque));
    EXPECT_EQ(fast.monitor.torque(), fast.monitor.bands().by_power().torque);
  }
}

// The machine has been magnetised and turns; torque is commanded for the last 3 ms only.
TYPED_TEST(TorqueMonitorOf, TheBandIsNarrowFromTheStartOfTorque) {
  for (const double omega_m : {0.0, 20.0, 100.0}) {
    SCOPED_TRACE(omega_m);
    const SteadyMachine machine = at(omega_m, 15.0);
    Watched<TypeParam> settled;
    settled.settle(machine);
    Watched<TypeParam> started;
    (void)started.run(machine, 1.2, std::nullopt);
    EXPECT_EQ(started.monitor.torque(), TypeParam(0));
    EXPECT_FALSE(started.run(machine, 3e-3, 15.0));
    EXPECT_NEAR(double(started.monitor.band().width()), double(settled.monitor.band().width()), 0.5);
  }
}

// Independent of the monitor's code: the machine differs from the parameters given, its torque is known.
TYPED_TEST(TorqueMonitorOf, TheBandsHoldTheTorqueOfAMachineWithinTheErrorsAllowedFor) {
  using T = TypeParam;
  const TorqueMonitorLimits<T> limits{.sensor_share = T(0.01), .current_offset = T(0)};
  for (const double r_s : {1.0 / 1.5, 2.0}) {
    for (const double r_r : {1.0 / 1.5, 1.0, 2.0}) {
      for (const double l_m : {1.0 / 1.3, 1.0, 1.0 / 0.7}) {
        InductionMachineParameters<double> truth;
        truth.r_s *= r_s;
        truth.r_r *= r_r;
        truth.l_m *= l_m;
        for (const double omega_m : {-50.0, 3.0, 200.0}) {
          for (const double torque : {-100.0, 15.0}) {
            SCOPED_TRACE(testing::Message() << r_s << ' ' << r_r << ' ' << l_m << ", " << omega_m
                                            << " rad/s, " << torque << " N·m");
            Watched<T> watched{limits};
            watched.settle(at(omega_m, torque, truth));
            const auto& by_current = watched.monitor.bands().by_current();
            EXPECT_LE(double(by_current.lowest), torque);
            EXPECT_GE(double(by_current.highest), torque);
            if (!watched.monitor.bands().has_power()) continue;
            const auto& by_power = watched.monitor.bands().by_power();
            EXPECT_LE(double(by_power.lowest), torque);
            EXPECT_GE(double(by_power.highest), torque);
          }
        }
      }
    }
  }
}

// τ_e changes by −3/2 p ΔR_s |i_s|²/ω_e, by parts of the machine alone.
TYPED_TEST(TorqueMonitorOf, TheBandByPowerIsThatOfTheStatorResistance) {
  using T = TypeParam;
  const TorqueMonitorLimits<T> limits{.sensor_share = T(0), .current_offset = T(0)};
  const InductionMachineParameters<double> m;
  for (const double omega_m : {-80.0, 80.0}) {
    const SteadyMachine machine = at(omega_m, 40.0);
    Watched<T> watched{limits};
    watched.settle(machine);
    const double per_ohm = -1.5 * m.pole_pairs * dot(machine.i_s(0.0), machine.i_s(0.0)) / machine.omega_e();
    const double ends[] = {40.0 + per_ohm * m.r_s, 40.0 - per_ohm * m.r_s / 2.0};  // R_s to 2, to 1/2
    const auto& band = watched.monitor.bands().by_power();
    EXPECT_NEAR(double(band.lowest), std::min(ends[0], ends[1]), 0.3);
    EXPECT_NEAR(double(band.highest), std::max(ends[0], ends[1]), 0.3);
  }
}

// The torque at the same currents, by the flux equation in steady state: with x = τ_r ω_slip the given
// machine's is proportional to L_m²/L_r x/(1 + x²), the true one's with x L_m/L_r of its own by R_r.
TYPED_TEST(TorqueMonitorOf, TheBandByCurrentIsThatOfRotorResistanceAndInductance) {
  using T = TypeParam;
  const TorqueMonitorLimits<T> limits{.sensor_share = T(0), .current_offset = T(0)};
  const SteadyMachine machine = at(0.0, 15.0);
  Watched<T> watched{limits};
  watched.settle(machine);
  const double i_squared = dot(machine.i_s(0.0), machine.i_s(0.0));
  double lowest = 15.0;
  double highest = 15.0;
  for (const double r_r : {1.0 / 1.5, 2.0}) {
    for (const double l_m : {1.0 / 1.3, 1.0 / 0.7}) {
      InductionMachineParameters<double> other;
      other.r_r *= r_r;
      other.l_m *= l_m;
      const double x = other.tau_r() * machine.omega_e();
      const double torque = 1.5 * other.pole_pairs * other.k_r() * other.l_m * i_squared * x / (1.0 + x * x);
      lowest = std::min(lowest, torque);
      highest = std::max(highest, torque);
    }
  }
  EXPECT_NEAR(double(watched.monitor.bands().by_current().lowest), lowest, 0.2);
  EXPECT_NEAR(double(watched.monitor.bands().by_current().highest), highest, 0.2);
}

TYPED_TEST(TorqueMonitorOf, ADeviationIsAFaultJustBeyondLimitAndBandAndNotJustInside) {
  for (const double omega_m : {-100.0, 0.0, 100.0}) {
    for (const double torque : {-100.0, 15.0}) {
      SCOPED_TRACE(std::to_string(omega_m) + " rad/s, " + std::to_string(torque) + " N·m");
      const SteadyMachine machine = at(omega_m, torque);
      Watched<TypeParam> watched;
      watched.settle(machine);
      const double low = double(watched.monitor.band().lowest);
      const double high = double(watched.monitor.band().highest);
      EXPECT_FALSE(watched.run(machine, 0.1, high + 9.9));
      EXPECT_FALSE(watched.run(machine, 0.1, low - 9.9));
      EXPECT_LT(watched.time_to_fault(machine, high + 11.0), 0.0101);
      watched.settle(machine);
      EXPECT_LT(watched.time_to_fault(machine, low - 11.0), 0.0101);
    }
  }
}

TYPED_TEST(TorqueMonitorOf, OfALargeCommandTheShareCounts) {
  using T = TypeParam;
  const TorqueMonitorLimits<T> limits{.limit = T(1), .limit_share = T(0.2)};
  const SteadyMachine machine = at(150.0, 100.0);
  Watched<T> watched{limits};
  watched.settle(machine);
  const double high = double(watched.monitor.band().highest);
  EXPECT_FALSE(watched.run(machine, 0.1, high / 0.8 - 0.5));
  EXPECT_LT(watched.time_to_fault(machine, high / 0.8 + 0.5), 0.0101);
}

TYPED_TEST(TorqueMonitorOf, TorqueAgainstTheSignOfASmallCommandIsAFault) {
  for (const double sign : {-1.0, 1.0}) {
    const SteadyMachine machine = at(100.0, -11.0 * sign);
    Watched<TypeParam> watched;
    watched.settle(machine);
    const auto& band = watched.monitor.band();
    const double near = sign > 0.0 ? double(band.highest) : -double(band.lowest);
    ASSERT_LT(near, -5.5);
    ASSERT_GT(near, -9.0);  // within the limit of a command of zero
    EXPECT_FALSE(watched.run(machine, 0.1, 0.0));
    EXPECT_FALSE(watched.run(machine, 0.1, -sign * 0.5));
    EXPECT_LT(watched.time_to_fault(machine, sign * 0.5), 0.0101);
  }
}

TYPED_TEST(TorqueMonitorOf, AFaultNeedsItsTimeAndShorterDeviationsAreForgotten) {
  const SteadyMachine machine = at(100.0, 60.0);
  Watched<TypeParam> watched;
  watched.settle(machine);
  EXPECT_GT(watched.time_to_fault(machine, 0.0), 0.0089);
  EXPECT_FALSE(watched.run(machine, 0.0101, 60.0));
  // Steps of the command that the torque follows after 4 ms, a hundred times a second.
  for (int k = 0; k < 50; ++k) {
    EXPECT_FALSE(watched.run(machine, 0.004, -60.0));
    EXPECT_FALSE(watched.run(machine, 0.006, 60.0));
  }
  // More often wrong than right.
  bool fault = false;
  for (int k = 0; k < 12; ++k) {
    fault = fault || watched.run(machine, 0.002, 60.0);
    fault = fault || watched.run(machine, 0.008, -60.0);
  }
  EXPECT_TRUE(fault);
}

TYPED_TEST(TorqueMonitorOf, WithoutTorqueProductionThereIsNoFaultAndTheTimeBeginsAnew) {
  const SteadyMachine machine = at(100.0, 60.0);
  Watched<TypeParam> watched;
  watched.settle(machine);
  EXPECT_FALSE(watched.run(machine, 0.1, std::nullopt));
  EXPECT_EQ(watched.monitor.torque(), TypeParam(0));
  EXPECT_FALSE(watched.run(machine, 0.006, 0.0));
  EXPECT_FALSE(watched.run(machine, SteadyMachine::dt, std::nullopt));
  EXPECT_GT(watched.time_to_fault(machine, 0.0), 0.0089);
}

TYPED_TEST(TorqueMonitorOf, DisabledItEstimatesOnly) {
  Watched<TypeParam> watched{{.enabled = false}};
  const SteadyMachine machine = at(100.0, 60.0);
  watched.settle(machine);
  EXPECT_FALSE(watched.run(machine, 0.1, 0.0));
  EXPECT_NEAR(double(watched.monitor.torque()), 60.0, 0.2);
}

// A machine without flux, whose torque takes milliseconds by the voltage.
TYPED_TEST(TorqueMonitorOf, ATorqueThatLagsForAWholeAveragingTimeIsKnownAtItsEndAtEveryPeriod) {
  using T = TypeParam;
  for (const std::int32_t period_ns : {25'000, 40'000, 50'000, 100'000, 125'000, 200'000, 250'000}) {
    SCOPED_TRACE(period_ns);
    TorqueMonitor<T> monitor{{}};
    const Measurement<T> m{.u_dc = T(500), .applied = GatePattern{switch_states[0], period_ns}};
    const int averaging = 1'000'000 / period_ns;
    const auto run = [&](int periods, double command) {
      for (int k = 0; k < periods; ++k) (void)monitor.step(m, T(period_ns) * T(1e-9), T(command));
    };
    run(3 * averaging, 0.0);
    EXPECT_FALSE(monitor.lags());
    run(averaging - 1, 1000.0);
    EXPECT_FALSE(monitor.lags());
    run(1, 1000.0);
    EXPECT_TRUE(monitor.lags());
  }
}

TYPED_TEST(TorqueMonitorOf, AMachineThatGetsNoCurrentIsAFault) {
  using T = TypeParam;
  TorqueMonitor<T> monitor{{}};
  const Measurement<T> dead{.u_dc = T(530), .applied = GatePattern{switch_states[0], 25'000}};
  int periods = 0;
  while (periods < 1000 && !monitor.step(dead, T(25e-6), T(15))) ++periods;
  EXPECT_LE(periods, 400);
  EXPECT_GE(periods, 350);
}

/// Direct current along phase a at rest: flux grows, torque is zero.
template <class T>
bool trips_while_magnetised(T current, T commanded) {
  TorqueMonitor<T> monitor{{}};
  const Measurement<T> m{.i_abc = {current, -current / T(2), -current / T(2)},
                         .u_dc = T(530),
                         .applied = GatePattern{switch_states[0], 25'000}};
  for (int k = 0; k < 800; ++k) {
    if (monitor.step(m, T(25e-6), commanded)) return true;
  }
  return false;
}

TYPED_TEST(TorqueMonitorOf, WhileFluxBuildsUpFromZeroTorqueMayLack) {
  using T = TypeParam;
  EXPECT_FALSE(trips_while_magnetised<T>(T(13), T(60)));  // 0.19 Wb after 20 ms
  EXPECT_FALSE(trips_while_magnetised<T>(T(13), T(-60)));
  EXPECT_TRUE(trips_while_magnetised<T>(T(80), T(60)));  // half the reference after 9 ms
}

TYPED_TEST(TorqueMonitorOf, TheFluxDecaysWithGatesOffAndWithoutMeasurements) {
  using T = TypeParam;
  const InductionMachineParameters<double> m;
  const SteadyMachine machine = at(100.0, 60.0);
  Measurement<T> off;
  off.u_dc = T(530);
  off.omega_m = T(100);
  for (const bool measured : {false, true}) {
    SCOPED_TRACE(measured);
    Watched<T> watched;
    watched.settle(machine);
    constexpr double gap_s = 0.05;
    for (int k = 0; k < 2000; ++k) {
      if (measured) {
        off.applied = GatePattern{gates_off, 25'000};
        EXPECT_FALSE(watched.monitor.step(off, T(25e-6), T(60)));
      } else {
        watched.monitor.coast(T(25e-6));
      }
    }
    // The same currents again: the flux that is left makes the torque of the first averaging time.
    const double left = std::exp(-gap_s / m.tau_r());
    const double turned = gap_s * (m.pole_pairs * 100.0 - machine.omega_e());
    watched.n += std::llround(gap_s / SteadyMachine::dt);
    (void)watched.run(machine, 1e-3, 60.0);
    const double t = (double(watched.n) - 20.0) * SteadyMachine::dt;
    const SpaceVector<double> i = machine.i_s(t);
    const SpaceVector<double> direction = polar(1.0, turned);
    const SpaceVector<double> before = machine.psi_r(t);
    const SpaceVector<double> psi = left * (direction.alpha * before + direction.beta * rotate_90(before)) +
                                    (5e-4 / m.tau_r() * m.l_m) * i;
    const double expected = 1.5 * m.pole_pairs * m.k_r() * cross(psi, i);
    EXPECT_NEAR(double(watched.monitor.bands().by_current().torque), expected, 0.8);
  }
}

TYPED_TEST(TorqueMonitorOf, RefusesLimitsThatAreNone) {
  using T = TypeParam;
  using Limits = TorqueMonitorLimits<T>;
  const T nan = std::numeric_limits<T>::quiet_NaN();
  EXPECT_EQ(Limits{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), nan}) {
    EXPECT_NE((Limits{.flux_reference = bad}.validate()), nullptr);
    EXPECT_NE((Limits{.limit = bad}.validate()), nullptr);
    EXPECT_NE((Limits{.wrong_sign = bad}.validate()), nullptr);
  }
  for (const T bad : {T(-0.1), T(1), nan}) {
    EXPECT_NE((Limits{.limit_share = bad}.validate()), nullptr);
    EXPECT_NE((Limits{.r_s_share = bad}.validate()), nullptr);
    EXPECT_NE((Limits{.r_r_share = bad}.validate()), nullptr);
    EXPECT_NE((Limits{.l_m_share = bad}.validate()), nullptr);
    EXPECT_NE((Limits{.sensor_share = bad}.validate()), nullptr);
  }
  EXPECT_NE((Limits{.current_offset = T(-1)}.validate()), nullptr);
  EXPECT_NE((Limits{.time_ns = 1'500'000}.validate()), nullptr);
  EXPECT_NE((Limits{.window_ns = 0}.validate()), nullptr);
  EXPECT_NE((Limits{.machine = {.r_s = T(0)}}.validate()), nullptr);
}

// Steps of any length are the same path.
TYPED_TEST(TorqueMonitorOf, FluxWithoutCurrentTurnsAndDecaysExactlyInStepsOfAnyLength) {
  using T = TypeParam;
  const InductionMachineParameters<T> m;
  for (const T dt : {T(25e-6), T(1e-3), T(20e-3)}) {
    MonitoredFlux<T> flux{m};
    flux.step({T(50), T(20)}, T(0), T(0.05));
    const SpaceVector<T> begin = flux.psi_r();
    const int steps = int(std::lround(0.1 / double(dt)));
    for (int k = 0; k < steps; ++k) flux.step({}, T(150), dt);
    const double left = std::exp(-0.1 / double(m.tau_r()));
    const SpaceVector<double> turn = polar(left, 2.0 * 150.0 * 0.1);
    const double tolerance = 40.0 * steps * double(std::numeric_limits<T>::epsilon()) + 1e-6;
    EXPECT_NEAR(double(flux.psi_r().alpha), turn.alpha * double(begin.alpha) - turn.beta * double(begin.beta),
                tolerance);
    EXPECT_NEAR(double(flux.psi_r().beta), turn.alpha * double(begin.beta) + turn.beta * double(begin.alpha),
                tolerance);
  }
}

/// Steady state of the Γ circuit whose stator inductance saturates, by its equations, with a stator flux that
/// is real:
///   j ω_slip ψ_R = R_R (ψ_s − ψ_R)/L_σ,   i_s = ψ_s/L_s(ψ_s) + (ψ_s − ψ_R)/L_σ,
///   L_s(ψ) = L_su/(1 + (ψ/ψ_k)^S)
struct SaturatedCircuit {
  using Complex = std::complex<double>;

  SaturatedCircuit(const InductionMachineParameters<double>& m, const SaturationParameters<double>& curve,
                   double psi_s, double omega_slip) {
    const double l_s = m.l_ls + m.l_m;
    const double gamma = l_s / m.l_m;
    const double l_sigma = gamma * m.l_ls + gamma * gamma * m.l_lr;
    const double r_r = gamma * gamma * m.r_r;
    const auto y = [&curve](double psi) { return std::pow(psi / curve.knee, curve.exponent); };
    const double present = l_s * (1 + y(curve.machine_flux)) / (1 + y(psi_s));
    const Complex psi_big_r = psi_s / (1.0 + Complex{0.0, omega_slip * l_sigma / r_r});
    i_s = psi_s / present + (psi_s - psi_big_r) / l_sigma;
    psi_r = std::abs(psi_big_r) / gamma;
    torque = 1.5 * m.pole_pairs * psi_s * i_s.imag();
  }

  Complex i_s;      ///< [A]
  double psi_r{};   ///< of the T circuit [Wb]
  double torque{};  ///< [N·m]
};

// In weakening the iron has more inductance than at the flux reference, above it less.
TYPED_TEST(TorqueMonitorOf, FollowsASaturationThatItIsGiven) {
  using T = TypeParam;
  const InductionMachineParameters<double> machine;
  const SaturationParameters<double> curve{.knee = 1.0, .exponent = 6, .machine_flux = 1.1};
  TorqueMonitorLimits<T> limits;
  limits.saturation = {
      .knee = T(curve.knee), .exponent = curve.exponent, .machine_flux = T(curve.machine_flux)};
  for (const double psi_s : {0.4, 0.8, 1.1, 1.2}) {
    for (const double omega_slip : {-8.0, 0.0, 3.0}) {
      SCOPED_TRACE(testing::Message() << psi_s << " Wb, " << omega_slip << " rad/s");
      const SaturatedCircuit circuit{machine, curve, psi_s, omega_slip};
      TorqueMonitor<T> monitor{limits};
      for (int k = 0; k < 8000; ++k) {
        const std::complex<double> i = circuit.i_s * std::polar(1.0, omega_slip * k * 250e-6);
        Measurement<T> m;
        m.i_abc = inverse_clarke(SpaceVector<T>{T(i.real()), T(i.imag())});
        m.u_dc = T(530);
        m.applied = {{LegState::low, LegState::low, LegState::low}, 250'000};
        (void)monitor.step(m, T(250e-6), T(0));
      }
      EXPECT_NEAR(double(magnitude(monitor.psi_r())), circuit.psi_r, 0.002);
      EXPECT_NEAR(double(monitor.bands().by_current().torque), circuit.torque,
                  0.003 * std::abs(circuit.torque) + 0.02);
    }
  }
}

}  // namespace
}  // namespace sextant
