#include "sextant/config/commissioning_config.hpp"

#include <numbers>

#include "shared_control_keys.hpp"

namespace sextant {

namespace {

constexpr Range<double> tone_hz{1e-4, 1e4};

}  // namespace

void describe(Section s, CommissioningController<>::Parameters& p, const ControlSetup& setup) {
  using Parameters = CommissioningController<>::Parameters;
  describe_magnetiser(s, p.magnetiser, setup);
  s.choice("course", p.course,
           {{"levels", CommissioningCourse::levels}, {"tones", CommissioningCourse::tones}},
           "direct currents, for dead time and stator resistance; or sines above a direct current, for the "
           "impedance at standstill");
  s.derived(
      "current_limit_a", p.highest_current, {0.1, 1e5}, "A",
      "limit of the current; by default magnetising_current_a. Levels go from a fifth of nearly all of it "
      "up, and sines likewise, of the current of the flux reference where that is smaller",
      [&p] { return p.magnetiser.current_limit; });
  s.integer("levels", p.levels, {2, 100}, "", "levels of the direct current, of each sign");
  s.integer("tones", p.tones, {2, 20}, "", "frequencies of the sine, in equal ratios");
  s.integer("blocks", p.blocks, {2, 100}, "", "measurements of each tone");
  const std::string rule = "no usable frequency follows from the machine";
  s.derived(
      "lowest_tone_hz", p.lowest_frequency, tone_hz, "Hz",
      "lowest frequency of the sine; by default that of the rotor's time constant, at which the rotor "
      "tells R_r and L_m",
      [&setup] { return Parameters::default_lowest_frequency(setup.machine); }, rule, 2.0 * std::numbers::pi);
  s.derived(
      "highest_tone_hz", p.highest_frequency, tone_hz, "Hz",
      "highest frequency of the sine; by default that at which the leakage inductance takes twice the "
      "voltage of the resistances, within what the current's control follows",
      [&setup] { return Parameters::default_highest_frequency(setup.machine, setup.period_ns); }, rule,
      2.0 * std::numbers::pi);
  s.derived_time<std::int64_t>(
      "settle_ms", p.settle_ns, 1e6, {0.01, 1e6}, "ms",
      "time before a level or a tone counts; by default 7 time constants of the rotor",
      [&setup] { return Parameters::default_settle_ns(setup.machine); });
  s.time("hold_ms", p.hold_ns, 1e6, {0.01, 1e6}, "ms",
         "time for which a level counts, and a block of a tone at least");
}

}  // namespace sextant
