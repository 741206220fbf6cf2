#pragma once

#include <cmath>

namespace sextant {

/// Accuracy of an integrator with a variable step, and its limits. The defaults are of local errors,
/// which occur after each of some 30 000 switching edges in a second and add up: a torque within 1e-6
/// of its peak takes a relative tolerance below 1e-9.
struct ErrorControl {
  double relative_tolerance{1e-11};  ///< local error of a step, relative to each state [-]
  double flux_tolerance{1e-13};      ///< absolute, flux linkages [Wb]
  double speed_tolerance{1e-11};     ///< absolute, mechanical speed [rad/s]
  double angle_tolerance{1e-11};     ///< absolute, mechanical angle [rad]
  double appended_tolerance{1e-9};   ///< absolute, states of the appended system [in their units]
  int max_steps{10'000};             ///< internal steps of one segment between events, at most [-]
  int max_events{1'000};             ///< diode events of one segment, at most [-]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto positive = [](double x) { return std::isfinite(x) && x > 0.0; };
    if (!positive(relative_tolerance)) return "the relative tolerance must be finite and above zero";
    if (!positive(flux_tolerance) || !positive(speed_tolerance) || !positive(angle_tolerance) ||
        !positive(appended_tolerance)) {
      return "the absolute tolerances must be finite and above zero";
    }
    if (max_steps < 1) return "the internal steps of a segment must be at least one";
    if (max_events < 1) return "the events of a segment must be at least one";
    return nullptr;
  }
};

}  // namespace sextant
