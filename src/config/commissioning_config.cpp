#include "sextant/config/commissioning_config.hpp"

#include "shared_control_keys.hpp"

namespace sextant {

void describe(Section s, CommissioningController<>::Parameters& p, const ControlSetup& setup) {
  describe_magnetiser(s, p.magnetiser, setup);
  s.derived("current_limit_a", p.highest_current, {0.1, 1e5}, "A",
            "limit of the direct current; by default magnetising_current_a. The levels go from a fifth of "
            "nearly all of it up",
            [&p] { return p.magnetiser.current_limit; });
  s.integer("levels", p.levels, {2, 100}, "", "levels of the direct current, of each sign");
  s.derived_time<std::int64_t>(
      "settle_ms", p.settle_ns, 1e6, {0.01, 1e6}, "ms",
      "time before a level counts; by default 7 time constants of the rotor",
      [&setup] { return CommissioningController<>::Parameters::default_settle_ns(setup.machine); });
  s.time("hold_ms", p.hold_ns, 1e6, {0.01, 1e6}, "ms", "time for which a level counts");
}

}  // namespace sextant
