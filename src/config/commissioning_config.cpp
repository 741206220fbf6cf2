#include "sextant/config/commissioning_config.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shared_control_keys.hpp"

namespace sextant {

namespace {

constexpr Range<double> tone_hz{1e-4, 1e4};

/// Where the rotor's branch is half resistance and half inductance, by the controller's machine. [rad/s]
double lowest_tone(const ControlSetup& setup) {
  return 1.0 / setup.machine.tau_r();
}

/// Where σL_s takes twice the voltage of the resistances; at most a quarter of the bandwidth of the current's
/// control, so that the amplitude keeps the limit. [rad/s]
double highest_tone(const ControlSetup& setup) {
  const InductionMachineParameters<>& m = setup.machine;
  const double corner = (m.r_s + m.k_r() * m.k_r() * m.r_r) / m.sigma_l_s();
  return std::min(2.0 * corner, 0.25 * CommissioningController<>::loop_share / (1e-9 * setup.period_ns));
}

}  // namespace

void describe(Section s, CommissioningController<>::Parameters& p, const ControlSetup& setup) {
  describe_magnetiser(s, p.magnetiser, setup);
  s.choice("course", p.course,
           {{"levels", CommissioningCourse::levels}, {"tones", CommissioningCourse::tones}},
           "direct currents, for dead time and stator resistance; or sines above a direct current, for the "
           "impedance at standstill");
  s.derived("current_limit_a", p.highest_current, {0.1, 1e5}, "A",
            "limit of the current; by default magnetising_current_a. Levels and sines go from a fifth of "
            "nearly all of it up",
            [&p] { return p.magnetiser.current_limit; });
  s.integer("levels", p.levels, {2, 100}, "", "levels of the direct current, of each sign");
  s.integer("tones", p.tones, {2, 20}, "", "frequencies of the sine, in equal ratios");
  s.integer("blocks", p.blocks, {2, 100}, "", "measurements of each tone");
  const std::string rule = "no usable frequency follows from the machine";
  s.derived(
      "lowest_tone_hz", p.lowest_frequency, tone_hz, "Hz",
      "lowest frequency of the sine; by default that of the rotor's time constant, at which the rotor "
      "tells R_r and L_m",
      [&setup] { return lowest_tone(setup); }, rule, 2.0 * std::numbers::pi);
  s.derived(
      "highest_tone_hz", p.highest_frequency, tone_hz, "Hz",
      "highest frequency of the sine; by default that at which the leakage inductance takes twice the "
      "voltage of the resistances, within what the current's control follows",
      [&setup] { return highest_tone(setup); }, rule, 2.0 * std::numbers::pi);
  // Of a step of the rotor's EMF a thousandth is left.
  s.derived_time<std::int64_t>(
      "settle_ms", p.settle_ns, 1e6, {0.01, 1e6}, "ms",
      "time before a level or a tone counts; by default 7 time constants of the rotor",
      [&setup] { return std::llround(7e9 * setup.machine.tau_r()); });
  s.time("hold_ms", p.hold_ns, 1e6, {0.01, 1e6}, "ms",
         "time for which a level counts, and a block of a tone at least");
}

}  // namespace sextant
