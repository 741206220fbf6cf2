#pragma once

#include <cmath>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/plant/at_switching.hpp"

namespace sextant {

/// Largest local error of a step: relative |x| + absolute.
struct Tolerances {
  double relative{};  ///< of flux vectors, speed and angle [-]
  double flux{};      ///< absolute, flux linkages [Wb]
  double speed{};     ///< absolute, mechanical speed [rad/s]
  double angle{};     ///< absolute, mechanical angle [rad]
  double appended{};  ///< absolute, states of the appended system [in their units]
};

/// Accuracy of an integrator with a variable step, and its limits.
///
/// Where it stops at each switching, local errors occur after each of some 30 000 edges in a second and add
/// up: a torque within 1e-6 of its peak takes a relative tolerance below 1e-9; the default is 1e-11, and the
/// absolute tolerances that are not set are 1e-13 Wb, 1e-11 rad/s and 1e-11 rad. Where it goes on over the
/// switching the relative tolerance is 1e-7, and tighter gains nothing; the absolute ones are 0.01 Wb,
/// 1000 rad/s and 1000 rad times as much: the slope of the speed has a corner at each switching, and steps
/// that shorten for it lose more accuracy than they gain. That of an appended state is 1e-9.
struct ErrorControl {
  std::optional<double> relative_tolerance{};  ///< local error of a step, relative to each state [-]
  std::optional<double> flux_tolerance{};      ///< absolute, flux linkages [Wb]
  std::optional<double> speed_tolerance{};     ///< absolute, mechanical speed [rad/s]
  std::optional<double> angle_tolerance{};     ///< absolute, mechanical angle [rad]
  std::optional<double> appended_tolerance{};  ///< absolute, states of the appended system [in their units]
  AtSwitching at_switching{AtSwitching::by_tolerance};
  int max_steps{10'000};  ///< internal steps of one segment between events, at most [-]
  int max_events{1'000};  ///< diode events of one segment, at most [-]

  /// True where the integrator stops at each switching.
  [[nodiscard]] bool stops() const noexcept {
    if (at_switching != AtSwitching::by_tolerance) return at_switching == AtSwitching::stop;
    return relative_tolerance.value_or(relative_on_going) < relative_on_going;
  }

  /// Those in force where the integrator stops at each switching, or goes on.
  [[nodiscard]] Tolerances tolerances(bool stops_there) const noexcept {
    if (stops_there) {
      return {relative_tolerance.value_or(relative_stopping), flux_tolerance.value_or(1e-13),
              speed_tolerance.value_or(1e-11), angle_tolerance.value_or(1e-11),
              appended_tolerance.value_or(1e-9)};
    }
    const double relative = relative_tolerance.value_or(relative_on_going);
    return {relative, flux_tolerance.value_or(1e-2 * relative), speed_tolerance.value_or(1e3 * relative),
            angle_tolerance.value_or(1e3 * relative), appended_tolerance.value_or(1e-9)};
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    const auto usable = [](const std::optional<double>& x) { return !x || (std::isfinite(*x) && *x > 0.0); };
    if (!usable(relative_tolerance)) return "the relative tolerance must be finite and above zero";
    if (!usable(flux_tolerance) || !usable(speed_tolerance) || !usable(angle_tolerance) ||
        !usable(appended_tolerance)) {
      return "the absolute tolerances must be finite and above zero";
    }
    if (max_steps < 1) return "the internal steps of a segment must be at least one";
    if (max_events < 1) return "the events of a segment must be at least one";
    return nullptr;
  }

 private:
  static constexpr double relative_on_going = 1e-7;
  static constexpr double relative_stopping = 1e-11;
};

inline void describe(Description& d, ErrorControl& p) {
  auto& [relative_tolerance, flux_tolerance, speed_tolerance, angle_tolerance, appended_tolerance,
         at_switching, max_steps, max_events] = p;
  d.choice("at_switching", at_switching,
           {{"by_tolerance", AtSwitching::by_tolerance},
            {"go_on", AtSwitching::go_on},
            {"stop", AtSwitching::stop}},
           "where the inverter switches with every leg driven: go on, restart, or restart where the relative "
           "tolerance is below 1e-7");
  d.number("relative_tolerance", relative_tolerance,
           {"", 1e-14, 1e-1,
            "local error of a step, of each state; 1e-7 where it goes on, 1e-11 where it restarts"});
  d.number("flux_tolerance_wb", flux_tolerance,
           {"Wb", 1e-14, 1e-1,
            "absolute, of flux linkages; 0.01 Wb times the relative one where it goes on, else 1e-13 Wb"});
  d.number("speed_tolerance_rad_s", speed_tolerance,
           {"rad/s", 1e-14, 1e-1,
            "absolute, of the speed; 1000 rad/s times the relative one where it goes on, else 1e-11 rad/s"});
  d.number("angle_tolerance_rad", angle_tolerance,
           {"rad", 1e-14, 1e-1,
            "absolute, of the shaft's angle; 1000 rad times the relative one where it goes on, else 1e-11 "
            "rad"});
  d.number("appended_tolerance", appended_tolerance, {"", 1e-14, 1e-1, "absolute, of appended states; 1e-9"});
  d.integer("max_steps", max_steps, "", 1, 100'000'000, "internal steps between two switching instants");
  d.integer("max_events", max_events, "", 1, 100'000'000, "diode events between two switching instants");
}

}  // namespace sextant
