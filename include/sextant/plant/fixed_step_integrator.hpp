#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/plant_integrator.hpp"
#include "sextant/plant/step_count.hpp"

namespace sextant {

/// What bounds the time of a fixed-step integration.
struct FixedStepParameters {
  std::int32_t max_step_ns{
      25'000};  ///< longest step; a machine that is too fast for it gets shorter ones [ns]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    return max_step_ns > 0 ? nullptr : "the longest step must be above zero";
  }
};

/// Classical Runge-Kutta method of order 4 with equal steps, in bounded time. A segment is divided into steps
/// of at most `max_step_ns` and of at most `largest_angle` divided by the plant's fastest rate at the
/// beginning of the segment, so that the error stays below 1e-6 of the peak torque and the method far inside
/// its region of stability (2.8) at any speed, on any machine. While legs are off, diode events are located
/// within the step by bisection on its cubic Hermite interpolant and the step is taken up to the event.
/// Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", II.1 and II.6.
template <class Plant>
class FixedStepIntegrator final : public PlantIntegrator<Plant> {
 public:
  using T = typename Plant::Scalar;
  using State = typename Plant::State;

  /// Largest product of a step and of the plant's fastest rate. The error goes with its fourth power; at 0.04
  /// it was at most 3e-7 of the peak torque on the machines of tests/python/machines.py. [-]
  static constexpr T largest_angle = T(0.04);

  /// The parameters must be valid.
  explicit FixedStepIntegrator(const FixedStepParameters& parameters = {}) noexcept
      : max_step_ns_{parameters.max_step_ns} {}

  [[nodiscard]] bool advance(Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING override {
    if (duration_ns <= 0) return true;
    const T total = T(duration_ns) * T(1e-9);
    const std::int64_t steps = steps_for(plant, duration_ns, total);
    if (steps == 0) return false;
    const T h = steps == 1 ? total : total / T(steps);
    return plant.has_events() ? advance_through_events(plant, h, steps) : advance_smoothly(plant, h, steps);
  }

  void reset() noexcept SEXTANT_NONBLOCKING override {}

  /// The longest step for the plant as it is. [s]
  [[nodiscard]] static T longest_step(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    return largest_angle / std::sqrt(fastest_rate_squared(plant));
  }

 private:
  static constexpr int bisections = 40;
  static constexpr int max_events_per_step = 16;

  static T fastest_rate_squared(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    const T electrical = plant.electrical_rate();
    return electrical * electrical + plant.shaft_rate_squared();
  }

  /// 0 when they are too many.
  [[nodiscard]] std::int64_t steps_for(const Plant& plant, std::int64_t duration_ns,
                                       T duration) const noexcept SEXTANT_NONBLOCKING {
    const std::int64_t steps = steps_of(duration_ns, max_step_ns_);
    const T step = steps == 1 ? duration : duration / T(steps);
    const T square = step * step * fastest_rate_squared(plant);
    if (square <= largest_angle * largest_angle) [[likely]]
      return steps;
    return at_least(steps, T(steps) * std::sqrt(square) / largest_angle);
  }

  /// The state after a step of h [s] from x with the slope k1 there; slope: dx/dt by x.
  template <class Slope>
  static State step(const Slope& slope, const State& x, const State& k1, T h) noexcept SEXTANT_NONBLOCKING {
    State k2, k3, k4;
    slope(along(x, T(0.5) * h, k1), k2);
    slope(along(x, T(0.5) * h, k2), k3);
    slope(along(x, h, k3), k4);
    State next;
    for (int i = 0; i < Plant::size; ++i)
      next[i] = x[i] + (h / T(6)) * (k1[i] + T(2) * (k2[i] + k3[i]) + k4[i]);
    return next;
  }

  /// x + h k. By element.
  static State along(const State& x, T h, const State& k) noexcept SEXTANT_NONBLOCKING {
    State y;
    for (int i = 0; i < Plant::size; ++i) y[i] = x[i] + h * k[i];
    return y;
  }

  [[gnu::flatten]] static bool advance_smoothly(Plant& plant, T h,
                                                std::int64_t steps) noexcept SEXTANT_NONBLOCKING {
    const auto slope = [&plant](const State& x, State& dx) noexcept { plant.driven_derivative(x, dx); };
    State x = plant.state();
    State k1;
    for (std::int64_t n = 0; n < steps; ++n) {
      slope(x, k1);
      x = step(slope, x, k1, h);
    }
    if (!x.allFinite()) return false;
    plant.continue_at(x);
    return true;
  }

  static bool advance_through_events(Plant& plant, T h, std::int64_t steps) noexcept SEXTANT_NONBLOCKING {
    const Plant before = plant;
    for (std::int64_t n = 0; n < steps; ++n) {
      if (!step_through_events(plant, h)) {
        plant = before;
        return false;
      }
    }
    return true;
  }

  static bool step_through_events(Plant& plant, T h) noexcept SEXTANT_NONBLOCKING {
    const auto slope = [&plant](const State& x, State& dx) noexcept { plant.derivative(x, dx); };
    T left = h;
    for (int events = 0; events <= max_events_per_step; ++events) {
      const State x0 = plant.state();
      State k0, k1;
      slope(x0, k0);
      const State x1 = step(slope, x0, k0, left);
      if (!x1.allFinite()) return false;
      slope(x1, k1);
      const Interpolant path{x0, x1, left * k0, left * k1};
      const T crossing = first_crossing(plant, path);
      if (crossing >= T(1)) {
        plant.continue_at(x1);
        return true;
      }
      const int leg = lowest_event(plant, path.at(crossing));
      plant.continue_at(step(slope, x0, k0, crossing * left));
      plant.on_event(leg);
      left *= T(1) - crossing;
    }
    return false;
  }

  /// Cubic Hermite interpolation between both ends of a step, s from 0 to 1.
  struct Interpolant {
    State x0, x1, d0, d1;
    [[nodiscard]] State at(T s) const noexcept SEXTANT_NONBLOCKING {
      const T r = T(1) - s;
      return r * x0 + s * x1 + (s * r) * (r * d0 - s * d1 - (T(1) - T(2) * s) * (x1 - x0));
    }
  };

  static T lowest_value(const Plant& plant, const State& x) noexcept SEXTANT_NONBLOCKING {
    std::array<T, 3> g;
    plant.events(x, g);
    return std::min({g[0], g[1], g[2]});
  }
  static int lowest_event(const Plant& plant, const State& x) noexcept SEXTANT_NONBLOCKING {
    std::array<T, 3> g;
    plant.events(x, g);
    return int(std::min_element(g.begin(), g.end()) - g.begin());
  }

  /// Fraction of the step at which the first event function has just fallen below zero; 1 when none does.
  static T first_crossing(const Plant& plant, const Interpolant& path) noexcept SEXTANT_NONBLOCKING {
    T low = T(0);
    T high = T(1);
    // The middle is evaluated too, so that a dip within the step is rarely missed.
    if (lowest_value(plant, path.at(T(0.5))) < T(0)) {
      high = T(0.5);
    } else if (lowest_value(plant, path.x1) < T(0)) {
      low = T(0.5);
    } else {
      return T(1);
    }
    for (int n = 0; n < bisections; ++n) {
      const T middle = T(0.5) * (low + high);
      (lowest_value(plant, path.at(middle)) < T(0) ? high : low) = middle;
    }
    return high;
  }

  std::int64_t max_step_ns_;  ///< [ns]
};

}  // namespace sextant
