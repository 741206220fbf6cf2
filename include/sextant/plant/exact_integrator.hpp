#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/electrical_transition.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/plant_integrator.hpp"
#include "sextant/plant/step_count.hpp"

namespace sextant {

/// What bounds the time of an exact discretisation.
struct ExactParameters {
  std::int32_t max_step_ns{
      25'000};  ///< longest time over which the speed is frozen; shorter on a light shaft [ns]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    return max_step_ns > 0 ? nullptr : "the longest step must be above zero";
  }
};

inline void describe(Description& d, ExactParameters& p) {
  auto& [max_step_ns] = p;
  d.time("max_step_us", max_step_ns,
         in_us(0.1, 1e5,
               "longest time over which the speed is frozen, less on a light shaft; while legs are off "
               "plant.fixed counts"));
}

/// Exact discretisation at frozen speed, in bounded time, of a plant with a linear machine; another one it
/// does not move, and reports a failure. At a constant speed the electrical equations are linear and the
/// fluxes move without error (`ElectricalTransition`). Over a step the speed is frozen at its mean, predicted
/// from its first two derivatives; what its rise does beside is added to first order. The speed itself
/// follows by the trapezoidal rule corrected by its second derivative, the angle by the trapezoidal rule
/// alone. The appended system, which nothing depends on, follows by Simpson's rule, with the state in the
/// middle of the step from the cubic Hermite interpolant between its ends.
///
/// Where the speed is constant, fluxes and torque are exact to rounding whatever the step. Where it changes,
/// fluxes, torque, speed and appended system are of order 3 in the step, the angle of order 2; a segment is
/// divided into steps of at most `max_step_ns` that are short enough for the error of the torque to stay
/// below 1e-6 of its peak on a light shaft, too. The transition is kept and recomputed when the speed
/// or the step has changed, and by nothing else: when another plant, that is another machine, is given,
/// `reset()` is due first.
///
/// While events can come, as where a leg is off or an appended system feeds back, the plant is moved by the
/// fixed step of Runge and Kutta, which locates them. Source: M. Hochbruck, A. Ostermann, "Exponential
/// integrators", Acta Numerica 19, 2010; S. Blanes et al., "The Magnus expansion and some of its
/// applications", Physics Reports 470, 2009.
template <class Plant>
class ExactIntegrator final : public PlantIntegrator<Plant> {
 public:
  using T = typename Plant::Scalar;
  using State = typename Plant::State;

  /// The parameters must be valid.
  explicit ExactIntegrator(const ExactParameters& parameters = {},
                           const FixedStepParameters& legs_off = {}) noexcept
      : max_step_ns_{parameters.max_step_ns}, legs_off_{legs_off} {}

  [[nodiscard]] bool advance(Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING override {
    if (duration_ns <= 0) return true;
    if (plant.has_events()) return plant.is_linear() && legs_off_.advance(plant, duration_ns);
    const T total = T(duration_ns) * T(1e-9);
    const std::int64_t steps = steps_for(plant, duration_ns, total);
    if (steps == 0) return false;
    return advance_smoothly(plant, total / T(steps), steps);
  }

  void reset() noexcept SEXTANT_NONBLOCKING override { prepared_h_ = T(0); }

 private:
  /// Largest product of a step's angles, (Ωh)² (Ωh + λh) with λ the electrical rate and Ω that of the shaft.
  /// The error goes with it; at the limit it was at most 1e-7 of the peak torque on the machines of
  /// tests/python/machines.py. [-]
  static constexpr T largest_product = T(2e-6);
  static constexpr T half = T(1) / T(2);
  static constexpr T sixth = T(1) / T(6);
  static constexpr T twelfth = T(1) / T(12);

  /// 0 when they are too many.
  [[nodiscard]] std::int64_t steps_for(const Plant& plant, std::int64_t duration_ns,
                                       T duration) const noexcept SEXTANT_NONBLOCKING {
    const std::int64_t steps = steps_of(duration_ns, max_step_ns_);
    const T step = steps == 1 ? duration : duration / T(steps);
    const T shaft_squared = plant.shaft_rate_squared() * step * step;
    const T product = shaft_squared * (std::sqrt(shaft_squared) + plant.electrical_rate() * step);
    if (product <= largest_product) [[likely]]
      return steps;
    return at_least(steps, T(steps) * std::cbrt(product / largest_product));
  }

  [[gnu::flatten]] bool advance_smoothly(Plant& plant, T h, std::int64_t steps) noexcept SEXTANT_NONBLOCKING {
    if (!plant.is_linear()) return false;
    State x = plant.state();
    for (std::int64_t n = 0; n < steps; ++n) x = step(plant, x, h);
    if (!x.allFinite()) return false;
    plant.continue_at(x);
    return true;
  }

  State step(const Plant& plant, const State& x, T h) noexcept SEXTANT_NONBLOCKING {
    State k0;
    plant.driven_derivative(x, k0);
    const T curvature = plant.speed_curvature(x, k0);
    State next = x;
    move_fluxes(plant, k0, curvature, h, next);
    for (int i = Plant::omega; i < Plant::size; ++i) next[i] = x[i] + h * k0[i];
    next[Plant::omega] += half * (h * h) * curvature;
    State k1;
    plant.driven_derivative(next, k1);
    for (int i = Plant::omega; i < Plant::size; ++i) next[i] = x[i] + half * h * (k0[i] + k1[i]);
    next[Plant::omega] += twelfth * (h * h) * (curvature - plant.speed_curvature(next, k1));
    if constexpr (Plant::size > Plant::appended) append(plant, x, k0, k1, h, next);
    return next;
  }

  /// The appended system over the step from x to `next`, with the slopes k0 and k1 of its ends.
  static void append(const Plant& plant, const State& x, const State& k0, const State& k1, T h,
                     State& next) noexcept SEXTANT_NONBLOCKING {
    const State middle = half * (x + next) + (half * half * half * h) * (k0 - k1);
    State k;
    plant.driven_derivative(middle, k);
    for (int i = Plant::appended; i < Plant::size; ++i)
      next[i] = x[i] + sixth * h * (k0[i] + T(4) * k[i] + k1[i]);
  }

  /// x becomes the state at the end of the step as far as the fluxes go; k0 is the slope at its beginning.
  void move_fluxes(const Plant& plant, const State& k0, T curvature, T h,
                   State& x) noexcept SEXTANT_NONBLOCKING {
    const T p = plant.machine().pole_pairs();
    const ElectricalRates<T> rates = plant.electrical_rates();
    const T acceleration = k0[Plant::omega];
    const T rise = h * (half * acceleration + sixth * h * curvature);
    prepare(rates, p * (x[Plant::omega] + rise), h);

    const FluxPair<T> turned{rotate_90(SpaceVector<T>{x[Plant::psi_s_alpha], x[Plant::psi_s_beta]}),
                             rotate_90(SpaceVector<T>{x[Plant::psi_r_alpha], x[Plant::psi_r_beta]})};
    const FluxPair<T> slope{
        {k0[Plant::psi_s_alpha], k0[Plant::psi_s_beta]},
        SpaceVector<T>{k0[Plant::psi_r_alpha], k0[Plant::psi_r_beta]} + (p * rise) * turned.r};
    const FluxPair<T> change = transition_(slope);
    // What the speed's rise within the step does beside its mean: Magnus' commutator, h³/12 [A', A] x.
    const T c = twelfth * (h * h * h) * p * (acceleration + half * h * curvature);
    const SpaceVector<T> change_s = change.s - (c * rates.sr) * turned.r;
    const SpaceVector<T> change_r = change.r + (c * rates.rs) * turned.s;
    x[Plant::psi_s_alpha] += change_s.alpha;
    x[Plant::psi_s_beta] += change_s.beta;
    x[Plant::psi_r_alpha] += change_r.alpha;
    x[Plant::psi_r_beta] += change_r.beta;
  }

  void prepare(const ElectricalRates<T>& rates, T omega_e, T h) noexcept SEXTANT_NONBLOCKING {
    if (omega_e == prepared_omega_e_ && h == prepared_h_) return;
    transition_.prepare(rates, omega_e, h);
    prepared_omega_e_ = omega_e;
    prepared_h_ = h;
  }

  std::int64_t max_step_ns_;             ///< [ns]
  FixedStepIntegrator<Plant> legs_off_;  ///< moves the plant through diode events
  ElectricalTransition<T> transition_{};
  T prepared_omega_e_{};  ///< of the transition [rad/s]
  T prepared_h_{};        ///< of the transition; 0: none [s]
};

}  // namespace sextant
