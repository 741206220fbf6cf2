#include "sextant/config/deadbeat_config.hpp"

#include <utility>

#include "modulated_config.hpp"

namespace sextant {

void describe(Section s, DeadbeatController<>::Parameters& p, const ControlSetup& setup) {
  describe_modulated(std::move(s), p, setup);
}

bool trims_mean_torque(const DeadbeatController<>::Parameters& /*parameters*/) {
  return true;
}

}  // namespace sextant
