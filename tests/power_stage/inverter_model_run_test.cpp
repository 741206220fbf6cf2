// The drive's model of the inverter against the simulated one, whose legs are off in the dead times and whose
// diodes conduct by the machine's equations.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

#include "sextant/control/space_vector_modulator.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

constexpr double u_dc = 530.0;

/// What the model leaves of the difference between commanded and acted volt-seconds, by root mean square.
struct Errors {
  double commanded{};  ///< of an ideal inverter's [V·s]
  double model{};      ///< [V·s]
};

/// Runs a machine at a constant speed on modulated voltages that turn with it, with a period of random length
/// and direction now and then, and compares ∫u_s dt of each period.
class Comparison {
 public:
  Comparison(std::int32_t period_ns, const InverterModel<>::Parameters& inverter, const PatternKind kind)
      : period_ns_{period_ns},
        dead_s_{inverter.dead_time_ns * 1e-9},
        speed_{{.imposed_speed = ProfileParameters{.value = 30.0}}},
        plant_{parameters(period_ns, inverter).plant},
        io_{parameters(period_ns, inverter).io, plant_, integrator_, speed_},
        model_{inverter, plant_.machine().parameters().sigma_l_s()},
        modulator_{{.pattern = kind}} {}

  /// volts: of the vector that turns; flux: at the beginning, of both windings [Wb].
  Errors run(double volts, double flux, unsigned seed, int periods = 2'000) {
    std::mt19937 random{seed};
    std::uniform_real_distribution<double> draw{-1.0, 1.0};
    plant_.set_fluxes({flux, 0.0}, {flux, 0.0});
    Errors sum{};
    for (int k = 0; k <= periods; ++k) {
      compare(k * std::int64_t{period_ns_}, k > 1, sum);
      const double angle = 60.0 * k * period_ns_ * 1e-9 + 1.6;
      SpaceVector<> u = polar(volts, angle);
      if (k % 7 == 0) u += SpaceVector<>{60.0 * draw(random), 60.0 * draw(random)};
      io_.write(modulator_.step(u, u_dc, period_ns_, by_sign(plant_.i_abc())));
    }
    return {std::sqrt(sum.commanded / (periods - 1)), std::sqrt(sum.model / (periods - 1))};
  }

  /// The same with pulses of an active vector and of its opposite between zero vectors, for `longest_ns` at
  /// most, now and then from one period to the next.
  Errors run_pulses(std::int32_t longest_ns, double flux, unsigned seed, int periods = 2'000) {
    std::mt19937 random{seed};
    const auto draw = [&random](int lowest, int highest) {
      return std::uniform_int_distribution{lowest, highest}(random);
    };
    plant_.set_fluxes({flux, 0.0}, {flux, 0.0});
    Errors sum{};
    for (int k = 0; k <= periods; ++k) {
      compare(k * std::int64_t{period_ns_}, k > 1, sum);
      const int active = draw(1, 6);
      const std::int32_t begin_ns = draw(0, 1) * draw(1, longest_ns);
      const std::int32_t pulse_ns = draw(1, longest_ns);
      const std::int32_t end_ns = draw(0, 1) * draw(1, longest_ns);
      const std::int32_t rest_ns = (period_ns_ - begin_ns - pulse_ns - end_ns) / 2;
      GatePattern pattern;
      pattern.append({switch_states[std::size_t(draw(1, 6))], begin_ns});
      pattern.append({switch_states[std::size_t(7 * draw(0, 1))], rest_ns});
      pattern.append({switch_states[std::size_t(active)], pulse_ns});
      pattern.append(
          {switch_states[std::size_t(7 * draw(0, 1))], period_ns_ - begin_ns - pulse_ns - end_ns - rest_ns});
      pattern.append({switch_states[std::size_t((active + 2) % 6 + 1)], end_ns});
      io_.write(pattern);
    }
    return {std::sqrt(sum.commanded / (periods - 1)), std::sqrt(sum.model / (periods - 1))};
  }

 private:
  static SimulatedPowerStage::Parameters parameters(std::int32_t period_ns,
                                                    const InverterModel<>::Parameters& inverter) {
    SimulatedPowerStage::Parameters p;
    p.io.period_ns = period_ns;
    p.io.u_dc = u_dc;
    p.io.dead_time_ns = inverter.dead_time_ns;
    p.io.minimum_pulse = inverter.minimum_pulse;
    return p;
  }

  /// One dead time in the direction of each current, so that small voltages drive a current at all.
  [[nodiscard]] ThreePhase<> by_sign(const ThreePhase<>& i) const {
    const auto time = [dead = dead_s_](double x) { return std::copysign(dead, x); };
    return {time(i.a), time(i.b), time(i.c)};
  }

  void compare(std::int64_t t_ns, bool counts, Errors& sum) {
    const SpaceVector<> psi_before = plant_.psi_s();
    const SpaceVector<> i_before = plant_.i_s();
    const Measurement<> m = io_.read(t_ns);
    const SpaceVector<> beyond = clarke(model_.step(m.applied, m.i_abc, m.u_dc));
    if (!counts) return;
    const double dt = double(m.applied.duration_ns()) * 1e-9;
    const double r_s = plant_.machine().parameters().r_s;
    const SpaceVector<> true_beyond = plant_.psi_s() - psi_before +
                                      0.5 * dt * r_s * (i_before + plant_.i_s()) -
                                      volt_seconds(m.applied, u_dc);
    sum.commanded += dot(true_beyond, true_beyond);
    sum.model += dot(true_beyond - beyond, true_beyond - beyond);
  }

  std::int32_t period_ns_;
  double dead_s_;  ///< [s]
  MechanicalLoad speed_;
  SimulatedPowerStage::Plant plant_;
  FixedStepIntegrator<SimulatedPowerStage::Plant> integrator_{
      {.max_step_ns = 2'000, .at_switching = AtSwitching::stop}};
  SimulatedPowerStage::Io io_;
  InverterModel<> model_;
  SpaceVectorModulator<double> modulator_;
};

struct Setting {
  std::int32_t period_ns;
  std::int32_t dead_ns;
};

// At 8 V the currents are no larger than what they change by within a period, and stop in the dead times.
TEST(InverterModelRun, ItsVoltSecondsAreThoseOfThePlant) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  for (const Setting s :
       {Setting{25'000, 1'500}, Setting{25'000, 300}, Setting{125'000, 3'000}, Setting{250'000, 4'000}}) {
    for (const PatternKind kind : {PatternKind::symmetric, PatternKind::asymmetric}) {
      for (const double volts : {8.0, 40.0, 120.0}) {
        SCOPED_TRACE(testing::Message()
                     << s.period_ns << " ns, dead " << s.dead_ns << " ns, " << volts << " V");
        const Errors e = Comparison{s.period_ns, {.dead_time_ns = s.dead_ns}, kind}.run(volts, 0.3, seed);
        EXPECT_GT(e.commanded, 0.4 * u_dc * s.dead_ns * 1e-9) << "the case needs dead time";
        EXPECT_LT(e.model, 0.05 * e.commanded);
      }
    }
  }
}

TEST(InverterModelRun, SoAreTheyWithAMinimumPulse) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  for (const ShortPulses kind : {ShortPulses::dropped, ShortPulses::stretched}) {
    for (const std::int32_t dead_ns : {0, 1'000}) {
      for (const std::int32_t period_ns : {25'000, 125'000}) {
        SCOPED_TRACE(testing::Message() << period_ns << " ns, dead " << dead_ns << " ns, kind " << int(kind));
        const InverterModel<>::Parameters inverter{.dead_time_ns = dead_ns, .minimum_pulse = {2'000, kind}};
        const Errors e = Comparison{period_ns, inverter, PatternKind::symmetric}.run_pulses(3'000, 0.3, seed);
        EXPECT_GT(e.commanded, 0.15 * u_dc * 2'000 * 1e-9) << "the case needs short pulses";
        EXPECT_LT(e.model, 0.05 * e.commanded);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
