#include "sextant/config/flux_vector_config.hpp"

#include "magnetiser_config.hpp"

namespace sextant {

void describe(Section s, FluxVectorController<>::Parameters& p, const ControlSetup& setup) {
  describe_current_limit(s, p.current_limit, setup);
  describe_magnetiser(s, p.magnetiser, setup);
}

bool trims_mean_torque(const FluxVectorController<>::Parameters& /*parameters*/) {
  return false;
}

}  // namespace sextant
