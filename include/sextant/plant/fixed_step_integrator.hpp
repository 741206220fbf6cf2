#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "sextant/core/description.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/at_switching.hpp"
#include "sextant/plant/hermite_path.hpp"
#include "sextant/plant/plant_integrator.hpp"
#include "sextant/plant/runge_kutta.hpp"
#include "sextant/plant/segment_corners.hpp"
#include "sextant/plant/smooth_state.hpp"
#include "sextant/plant/step_count.hpp"
#include "sextant/plant/voltage_integral.hpp"
#include "sextant/plant/voltage_parabola.hpp"

namespace sextant {

/// What bounds the time of a fixed-step integration.
struct FixedStepParameters {
  std::int32_t max_step_ns{
      25'000};  ///< longest step; a machine that is too fast for it gets shorter ones [ns]
  AtSwitching at_switching{AtSwitching::go_on};  ///< go_on or stop

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (at_switching == AtSwitching::by_tolerance) return "a fixed step has no tolerance to go by";
    return max_step_ns > 0 ? nullptr : "the longest step must be above zero";
  }
};

inline void describe(Description& d, FixedStepParameters& p) {
  auto& [max_step_ns, at_switching] = p;
  d.time("max_step_us", max_step_ns,
         in_us(0.1, 1e5, "longest integration step; a machine that is too fast for it gets shorter ones"));
  d.choice("at_switching", at_switching, {{"go_on", AtSwitching::go_on}, {"stop", AtSwitching::stop}},
           "where the inverter switches with every leg driven: go on, or end a step");
}

/// Classical Runge-Kutta method of order 4 with equal steps, in bounded time. A segment is divided into steps
/// of at most `max_step_ns` and of at most `largest_angle` divided by the plant's fastest rate at the
/// beginning of the segment, so that the error stays below 1e-6 of the peak torque and the method far inside
/// its region of stability (2.8) at any speed, on any machine.
///
/// Where gate segments follow each other with every leg driven, the steps do not end at the corners between
/// them: the method moves psi_s − V, V the `VoltageIntegral`, whose slope does not jump. Within a step V is
/// replaced by the parabola with the same ends and the same area, which is exact for a symmetric pattern;
/// what a step neglects is of third order in V's deviation from it.
///
/// While legs are off, diode events are located
/// within the step on its cubic Hermite interpolant to 2^-41 of the step and the step is taken up to the
/// event. Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", II.1 and
/// II.6.
template <class Plant>
class FixedStepIntegrator final : public PlantIntegrator<Plant> {
 public:
  using T = typename Plant::Scalar;
  using State = typename Plant::State;
  using MachineState = typename Plant::MachineState;

  /// Largest product of a step and of the plant's fastest rate. The error goes with its fourth power; at 0.04
  /// it was at most 3e-7 of the peak torque on the machines of tests/python/machines.py. [-]
  static constexpr T largest_angle = T(0.04);

  /// The parameters must be valid.
  explicit FixedStepIntegrator(const FixedStepParameters& parameters = {}) noexcept
      : max_step_ns_{parameters.max_step_ns}, goes_on_{parameters.at_switching == AtSwitching::go_on} {}

  [[nodiscard]] bool advance(Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING override {
    if (duration_ns <= 0) return true;
    const T total = T(duration_ns) * T(1e-9);
    const std::int64_t steps = steps_for(plant, duration_ns, total);
    if (steps == 0) return false;
    const T h = steps == 1 ? total : total / T(steps);
    if (plant.has_events())
      return plant.is_linear() ? advance_through_events<true>(plant, h, steps)
                               : advance_through_events<false>(plant, h, steps);
    return plant.is_linear() ? advance_smoothly<true>(plant, h, steps)
                             : advance_smoothly<false>(plant, h, steps);
  }

  [[nodiscard]] bool advance_through(Plant& plant, std::span<const GateSegment> segments,
                                     std::span<State> corners) noexcept SEXTANT_NONBLOCKING override {
    if constexpr (Plant::appends_integrals) {
      if (segments.size() > 1 && goes_on_ && plant.is_driven_by(segments))
        return plant.is_linear() ? advance_over_corners<true>(plant, segments, corners)
                                 : advance_over_corners<false>(plant, segments, corners);
    }
    return PlantIntegrator<Plant>::advance_through(plant, segments, corners);
  }

  [[nodiscard]] bool advance_tied(Plant& plant, std::span<const GateSegment> segments,
                                  std::span<State> corners) noexcept SEXTANT_NONBLOCKING override {
    if constexpr (Plant::appends_integrals)
      return plant.is_linear() ? advance_over_corners<true, true>(plant, segments, corners)
                               : advance_over_corners<false, true>(plant, segments, corners);
    return false;
  }
  [[nodiscard]] bool ties() const noexcept SEXTANT_NONBLOCKING override {
    return Plant::appends_integrals && goes_on_;
  }

  void reset() noexcept SEXTANT_NONBLOCKING override {}

  /// The longest step for the plant as it is. [s]
  [[nodiscard]] static T longest_step(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    return largest_angle / std::sqrt(fastest_rate_squared(plant));
  }

 private:
  static constexpr int bisections = 40;
  static constexpr int last_bisections = 6;
  /// Of half a step, what the bisections before these leave. [-]
  static constexpr T interval = T(0.5) / T(std::uint64_t{1} << (bisections - last_bisections));
  static constexpr int max_events_per_step = 16;

  static T fastest_rate_squared(const Plant& plant) noexcept SEXTANT_NONBLOCKING {
    const T electrical = plant.electrical_rate();
    const T square = electrical * electrical + plant.shaft_rate_squared();
    if constexpr (Plant::feeds_back) return square + plant.appended_rate_squared();
    return square;
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

  /// is_linear: what the plant's machine says. That it is compared here tells the compiler, so that it is not
  /// tested in each evaluation of the machine's equations.
  template <bool is_linear>
  [[gnu::flatten]] static bool advance_smoothly(Plant& plant, T h,
                                                std::int64_t steps) noexcept SEXTANT_NONBLOCKING {
    if (plant.is_linear() != is_linear) return false;
    const auto slope = [&plant](T, const State& x, State& dx) noexcept { plant.driven_derivative(x, dx); };
    State x = plant.state();
    State k1;
    for (std::int64_t n = 0; n < steps; ++n) {
      slope(T(0), x, k1);
      x = runge_kutta_step(slope, x, k1, h);
    }
    if (!x.allFinite()) return false;
    plant.continue_at(x);
    return true;
  }

  /// is_linear as above. may_lose: the inverter may have a threshold.
  template <bool is_linear, bool may_lose = false>
  [[gnu::flatten]] bool advance_over_corners(Plant& plant, std::span<const GateSegment> segments,
                                             std::span<State> corners) const noexcept SEXTANT_NONBLOCKING
    requires(Plant::appends_integrals)
  {
    if (plant.is_linear() != is_linear) return false;
    const VoltageIntegral<T> voltage{segments, plant.inputs().u_dc,
                                     may_lose ? plant.threshold_voltage() : SpaceVector<T>{}};
    const T total = voltage.duration();
    const std::int64_t steps = steps_for(plant, voltage.duration_ns(), total);
    if (steps == 0) return false;
    const T h = total / T(steps);
    SegmentCorners<Plant, may_lose> at_corners{plant, segments, voltage, corners};
    const SmoothState<Plant> smooth_state{plant};
    MachineState x = plant.state().template head<Plant::machine_size>();
    MachineState k;
    plant.undriven_derivative(x, k);
    at_corners.begin(x, k);
    VoltageMoments<T> before{};
    for (std::int64_t n = 1; n <= steps; ++n) {
      const VoltageMoments<T> after = voltage(T(n) * h);
      x = step_over_corners(plant, x, k, h, {before, after, h});
      before = after;
      if (n == steps && !at_corners.wanted()) break;
      plant.undriven_derivative(x, k);
      if (at_corners.wanted())
        at_corners.step(h, smooth_state.smooth(x, after), smooth_state.slope(k, after.v));
    }
    if (!x.allFinite()) return false;
    plant.continue_at(at_corners.finish(x));
    plant.set_switch_state(segments.back().state);
    return true;
  }

  /// The machine's state after a step of h [s] from x, whose slope without the voltage is k1.
  static MachineState step_over_corners(const Plant& plant, const MachineState& x, const MachineState& k1,
                                        T h, const VoltageParabola<T>& v) noexcept SEXTANT_NONBLOCKING {
    const auto slope = [&plant, &v](T s, const MachineState& y, MachineState& dy) noexcept {
      plant.undriven_derivative(SmoothState<Plant>::raised(y, s < T(1) ? v.middle() : v.rise()), dy);
    };
    return SmoothState<Plant>::raised(runge_kutta_step(slope, x, k1, h), v.rise());
  }

  /// is_linear as above.
  template <bool is_linear>
  static bool advance_through_events(Plant& plant, T h, std::int64_t steps) noexcept SEXTANT_NONBLOCKING {
    State x = plant.state();
    const std::int64_t done =
        plant.inverter().voltage_is_fixed() ? steps_without_events<is_linear>(plant, x, h, steps) : 0;
    if (done == steps) {
      plant.continue_at(x);
      return true;
    }
    const Plant before = plant;
    if (done > 0) plant.continue_at(x);
    for (std::int64_t n = done; n < steps; ++n) {
      if (!step_through_events(plant, h)) {
        plant = before;
        return false;
      }
    }
    return true;
  }

  /// Moves x over steps of h [s] while no leg floats, up to the first step in which an event may come;
  /// returns how many it has moved over, `steps` at most.
  ///
  /// Such a step is looked at more closely by `step_through_events`. Here the slope at the end of a step is
  /// that of the last stage of the method, which differs from it in the third order of h, so that the middle
  /// of the step is nearly the same: where an event function is there above `clear` times the lower one of
  /// both ends, it does not fall through zero.
  template <bool is_linear>
  [[gnu::flatten]] static std::int64_t steps_without_events(const Plant& plant, State& x, T h,
                                                            std::int64_t steps) noexcept SEXTANT_NONBLOCKING {
    constexpr T clear = T(0.25);
    if (plant.is_linear() != is_linear) return 0;
    const auto slope = [&plant](T, const State& y, State& dy) noexcept { plant.fixed_derivative(y, dy); };
    typename Plant::Events at_begin, at_middle, at_end;
    plant.fixed_events(x, at_begin);
    for (std::int64_t n = 0; n < steps; ++n) {
      State k1, k4;
      slope(T(0), x, k1);
      const State end = runge_kutta_step(slope, x, k1, h, k4);
      if (!end.allFinite()) return n;
      plant.fixed_events(middle_of(x, end, k1, k4, h), at_middle);
      plant.fixed_events(end, at_end);
      for (std::size_t k = 0; k < at_end.size(); ++k) {
        const T least = std::min(at_begin[k], at_end[k]);
        if (!(least > T(0) && at_middle[k] > clear * least)) return n;
      }
      x = end;
      at_begin = at_end;
    }
    return steps;
  }

  /// In the middle of the cubic with these values and slopes at both ends of a step of h [s].
  static State middle_of(const State& x0, const State& x1, const State& k0, const State& k1,
                         T h) noexcept SEXTANT_NONBLOCKING {
    State x;
    for (int i = 0; i < Plant::size; ++i) x[i] = T(0.5) * (x0[i] + x1[i]) + (h / T(8)) * (k0[i] - k1[i]);
    return x;
  }

  static bool step_through_events(Plant& plant, T h) noexcept SEXTANT_NONBLOCKING {
    const auto slope = [&plant](T, const State& x, State& dx) noexcept { plant.derivative(x, dx); };
    T left = h;
    for (int events = 0; events <= max_events_per_step; ++events) {
      const State x0 = plant.state();
      State k0, k1;
      slope(T(0), x0, k0);
      const State x1 = runge_kutta_step(slope, x0, k0, left);
      if (!x1.allFinite()) return false;
      slope(T(1), x1, k1);
      const HermitePath<State> path{x0, x1, left * k0, left * k1};
      const T crossing = first_crossing(plant, path);
      if (crossing >= T(1)) {
        plant.continue_at(x1);
        return true;
      }
      const int event = lowest_event(plant, path.at(crossing));
      plant.continue_at(runge_kutta_step(slope, x0, k0, crossing * left));
      plant.on_event(event);
      left *= T(1) - crossing;
    }
    return false;
  }

  static T lowest_value(const Plant& plant, const State& x) noexcept SEXTANT_NONBLOCKING {
    typename Plant::Events g;
    plant.events(x, g);
    return *std::min_element(g.begin(), g.end());
  }
  static int lowest_event(const Plant& plant, const State& x) noexcept SEXTANT_NONBLOCKING {
    typename Plant::Events g;
    plant.events(x, g);
    return int(std::min_element(g.begin(), g.end()) - g.begin());
  }

  /// Fraction of the step at which the first event function has just fallen below zero; 1 when none does.
  static T first_crossing(const Plant& plant, const HermitePath<State>& path) noexcept SEXTANT_NONBLOCKING {
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
    return first_below(low, high,
                       [&](T s) noexcept SEXTANT_NONBLOCKING { return lowest_value(plant, path.at(s)); });
  }

  /// Where value(s), which is below zero at high and not at low, has just fallen below it: the end of the
  /// interval that `bisections` halvings leave. low and high are multiples of half a step. Where the value
  /// falls once, the false-position method of Illinois finds one of the intervals on the way in fewer
  /// evaluations; the last halvings, in which rounding may count, are made as they are.
  template <class Value>
  static T first_below(T low, T high, const Value& value) noexcept SEXTANT_NONBLOCKING {
    const T below = interval * std::floor(false_position(low, high, value) / interval);
    int left = bisections;
    if (below >= low && below + interval <= high && value(below + interval) < T(0) &&
        !(value(below) < T(0))) {
      low = below;
      high = below + interval;
      left = last_bisections;
    }
    for (int n = 0; n < left; ++n) {
      const T middle = T(0.5) * (low + high);
      (value(middle) < T(0) ? high : low) = middle;
    }
    return high;
  }

  /// Near the zero of value between low and high. Source: M. Dowell, P. Jarratt, "A modified regula falsi
  /// method for computing the root of an equation", BIT 11 (1971) 168–174.
  template <class Value>
  static T false_position(T low, T high, const Value& value) noexcept SEXTANT_NONBLOCKING {
    constexpr int most_iterations = 12;
    T at_low = value(low);
    T at_high = value(high);
    T last = high;
    int moved = 0;  // the end that moved in the last iteration: 1 the upper, −1 the lower
    for (int n = 0; n < most_iterations && at_low > T(0) && at_high < T(0); ++n) {
      const T s = (low * at_high - high * at_low) / (at_high - at_low);
      const bool arrived = std::abs(s - last) < T(0.25) * interval;
      last = s;
      if (arrived) break;
      const T at_s = value(s);
      const bool is_below = at_s < T(0);
      (is_below ? high : low) = s;
      (is_below ? at_high : at_low) = at_s;
      const int now = is_below ? 1 : -1;
      if (now == moved) (is_below ? at_low : at_high) *= T(0.5);
      moved = now;
    }
    return last;
  }

  std::int64_t max_step_ns_;  ///< [ns]
  bool goes_on_;              ///< over the switching within a call
};

}  // namespace sextant
