#include "shared_control_keys.hpp"

#include "sextant/control/predictive_controller.hpp"

namespace sextant {
namespace {

constexpr const char* trim_key = "torque_trim_ms";
constexpr const char* trim_meaning =
    "time constant with which the torque reference is trimmed until the mean of the estimated torque meets "
    "the command; 0: not trimmed";
constexpr Range<double> trim_range_ms{0, 1e4};

}  // namespace

void describe_magnetiser(Section s, Magnetiser<>::Parameters& p, const ControlSetup& setup) {
  const auto defaults = [&setup] { return Magnetiser<>::Parameters::by_default(setup); };
  s.derived("magnetising_current_a", p.current_limit, {0.1, 1e5}, "A",
            "limit of the stator current's magnitude while the flux is built up at standstill: the larger, "
            "the sooner there is torque",
            [defaults] { return defaults().current_limit; });
  s.derived("hand_over_current_a", p.hand_over_current, {0.1, 1e5}, "A",
            "largest magnitude of the stator current at which torque control follows magnetising",
            [defaults] { return defaults().hand_over_current; });
}

void describe_torque_trim(Section s, TorqueTrim<>::Parameters& p) {
  s.number(trim_key, {p.time_constant, 1e-3}, trim_range_ms, "ms", trim_meaning);
  s.changes(Changes::always);
}

void describe_torque_trim(Section s, TorqueTrim<>::Parameters& p, const ControlSetup& setup) {
  s.derived(
      trim_key, p.time_constant, trim_range_ms, "ms", trim_meaning,
      [&setup] { return default_parameters<PredictiveController<>>(setup).torque_trim.time_constant; },
      "no usable time constant follows from flux reference, link and control period", 1e-3);
  s.changes(Changes::always);
}

}  // namespace sextant
