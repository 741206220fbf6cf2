#include "sextant/config/field_oriented_config.hpp"

#include "modulated_config.hpp"

namespace sextant {

void describe(Section s, FieldOrientedController<>::Parameters& p, const ControlSetup& setup) {
  s.derived("bandwidth_rad_s", p.bandwidth, {1, 1e6}, "rad/s",
            "bandwidth with which the current follows its reference; by default 0.2, at most 0.5, divided by "
            "the control period",
            [&setup] { return FieldOrientedController<>::Parameters::default_bandwidth(setup.period_ns); });
  describe_modulated(s, p, setup);
}

bool trims_mean_torque(const FieldOrientedController<>::Parameters& /*parameters*/) {
  return true;
}

}  // namespace sextant
