#include "shared_control_keys.hpp"

#include "sextant/drive/drive_limits.hpp"

namespace sextant {

void describe_magnetiser(Section s, Magnetiser<>::Parameters& p, const ControlSetup& setup) {
  const auto limits = [&setup] { return drive_limits(setup.machine, setup.flux_reference, setup.u_dc); };
  s.derived("magnetising_current_a", p.current_limit, {0.1, 1e5}, "A",
            "limit of the stator current's magnitude while the flux is built up at standstill: the larger, "
            "the sooner there is torque",
            [limits] { return limits().magnetising_current; });
  s.derived("hand_over_current_a", p.hand_over_current, {0.1, 1e5}, "A",
            "largest magnitude of the stator current at which torque control follows magnetising",
            [limits] { return limits().hand_over_current; });
}

void describe_torque_trim(Section s, TorqueTrim<>::Parameters& p) {
  s.number("torque_trim_ms", p.time_constant, {0, 1e4}, "ms",
           "time constant with which the torque reference is trimmed until the mean of the estimated torque "
           "meets the command; 0: not trimmed",
           1e-3);
}

}  // namespace sextant
