#include "modulated_config.hpp"

#include "magnetiser_config.hpp"
#include "sextant/drive/steady_state.hpp"

namespace sextant {

void describe_modulated(Section s, ModulatedController<>::Parameters& p, const ControlSetup& setup) {
  s.derived("current_limit_a", p.current_limit, {0.1, 1e5}, "A",
            "largest magnitude of the stator current that the controller asks for, torque before the rise of "
            "the flux",
            [&setup] { return steady_state(setup.machine, setup.flux_reference, 1.0).current(); });
  describe_magnetiser(s, p.magnetiser, setup);
  s.choice(
      "pattern", p.modulator.pattern,
      {{"symmetric", PatternKind::symmetric}, {"asymmetric", PatternKind::asymmetric}},
      "each modulated leg switches twice a period, about its middle; or once, which halves the switching "
      "frequency");
  s.choice(
      "zero_vectors", p.modulator.zero_vectors,
      {{"both", ZeroVectors::both},
       {"low", ZeroVectors::low},
       {"high", ZeroVectors::high},
       {"alternating", ZeroVectors::alternating}},
      "both for the same time; V0 or V7 alone; or the one with which the leg of the largest voltage does "
      "not switch");
  s.choice("overmodulation", p.modulator.overmodulation,
           {{"magnitude", Overmodulation::magnitude}, {"angle", Overmodulation::angle}},
           "in the place of a voltage beyond the inverter's hexagon the nearest one, up to six-step, or the "
           "one in the same direction");
  s.time("shortest_pulse_us", p.modulator.shortest_pulse_ns, 1e3, {0, 1000}, "us",
         "shortest time for which a leg is high, or low, in a period; a shorter one is left out or "
         "lengthened");
}

}  // namespace sextant
