#include "sextant/config/flux_vector_config.hpp"

#include <utility>

#include "shared_control_keys.hpp"

namespace sextant {

void describe(Section s, FluxVectorController<>::Parameters& p, const ControlSetup& setup) {
  describe_magnetiser(s, p.magnetiser, setup);
  describe_torque_trim(std::move(s), p.torque_trim);
}

void describe(Section s, PredictiveController<>::Parameters& p, const ControlSetup& setup) {
  describe_magnetiser(s, p.magnetiser, setup);
  describe_torque_trim(std::move(s), p.torque_trim, setup);
}

}  // namespace sextant
