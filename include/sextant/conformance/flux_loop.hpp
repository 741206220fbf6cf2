#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "sextant/conformance/conformance_parameters.hpp"
#include "sextant/control/controller.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// A controller closed around an induction machine that turns slowly, without torque. It shows the stator
/// flux that the controller makes of a flux reference. In the stationary frame
///   dψ_s/dt = u_s − R_s i_s,   dψ_r/dt = −R_r i_r + j p ω_m ψ_r,
///   i_s = (ψ_s − k_r ψ_r)/σL_s,   i_r = (ψ_r − L_m i_s)/L_r
/// by the midpoint method in steps of at most 5 µs; legs that are off count as low.
/// Source: P. Vas, "Sensorless Vector and Direct Torque Control", Oxford 1998, section 2.1.
template <class T>
class FluxLoop {
 public:
  /// The controller must outlive the loop.
  FluxLoop(Controller<T>& controller, const ConformanceParameters& parameters)
      : controller_{controller}, p_{parameters} {}

  /// Until the controller tells that the flux is ready, or for ten rotor time constants.
  void magnetise() {
    const int most = periods(10.0 * p_.machine.tau_r());
    for (int k = 0; k < most && !(k > 0 && controller_.estimate().magnetised); ++k)
      (void)step({ControlMode::magnetise, T(0)});
  }

  /// The mean magnitude of the stator flux over the last 10 ms of this time in mode torque. [Wb]
  [[nodiscard]] double flux(double flux_share, double seconds) {
    const int counted = periods(0.01);
    const int all = std::max(counted, periods(seconds));
    double sum = 0.0;
    for (int k = 0; k < all; ++k) {
      const double now = step({ControlMode::torque, T(0), T(flux_share)});
      if (k >= all - counted) sum += now;
    }
    return sum / counted;
  }

 private:
  static constexpr double omega_m = 10.0;  ///< [rad/s]

  struct Flux {
    SpaceVector<double> s;  ///< of the stator [Wb]
    SpaceVector<double> r;  ///< of the rotor [Wb]
  };

  [[nodiscard]] int periods(double seconds) const { return int(std::lround(seconds * 1e9 / p_.period_ns)); }

  [[nodiscard]] SpaceVector<double> stator_current(const Flux& x) const {
    return (1.0 / p_.machine.sigma_l_s()) * (x.s - p_.machine.k_r() * x.r);
  }
  [[nodiscard]] Flux slope(const Flux& x, SpaceVector<double> u_s) const {
    const SpaceVector<double> i_s = stator_current(x);
    const SpaceVector<double> i_r = (1.0 / p_.machine.l_r()) * (x.r - p_.machine.l_m * i_s);
    return {u_s - p_.machine.r_s * i_s,
            (p_.machine.pole_pairs * omega_m) * rotate_90(x.r) - p_.machine.r_r * i_r};
  }

  void apply(const GatePattern& pattern) {
    constexpr std::int32_t longest_ns = 5'000;
    for (const GateSegment& segment : pattern.segments()) {
      const int steps = (segment.duration_ns + longest_ns - 1) / longest_ns;
      const SpaceVector<double> u_s = stator_voltage(segment.state, p_.u_dc);
      for (int k = 0; k < steps; ++k) {
        const double dt = 1e-9 * segment.duration_ns / steps;
        const Flux begin = slope(x_, u_s);
        const Flux middle = slope({x_.s + (0.5 * dt) * begin.s, x_.r + (0.5 * dt) * begin.r}, u_s);
        x_.s += dt * middle.s;
        x_.r += dt * middle.r;
      }
    }
  }

  /// One period; returns the magnitude of the stator flux at its end. [Wb]
  double step(ControlReference<T> reference) {
    const ThreePhase<double> i = inverse_clarke(stator_current(x_));
    Measurement<T> m;
    m.i_abc = {T(i.a), T(i.b), T(i.c)};
    m.u_dc = T(p_.u_dc);
    m.omega_m = T(omega_m);
    m.applied = applied_;
    const GatePattern decided = controller_.step(m, reference);
    applied_ = p_.actuation_delay_periods == 1 ? std::exchange(in_flight_, decided) : decided;
    apply(applied_);
    return magnitude(x_.s);
  }

  Controller<T>& controller_;
  ConformanceParameters p_;
  Flux x_{};
  GatePattern applied_{gates_off, p_.period_ns};
  GatePattern in_flight_{switch_states[0], p_.period_ns};
};

}  // namespace sextant
