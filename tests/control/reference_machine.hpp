#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant::test {

/// Induction machine at imposed speed behind an ideal inverter, integrated by RK4 in complex numbers. It
/// shares no equation with the code under test: currents come from the inverse of the inductance matrix.
class ReferenceMachine {
 public:
  using Complex = std::complex<double>;

  explicit ReferenceMachine(const InductionMachineParameters<double>& parameters = {}, double u_dc = 530)
      : p_{parameters}, u_dc_{u_dc} {}

  double omega_m{};                       ///< imposed mechanical speed [rad/s]
  Complex psi_s{};                        ///< [Wb]
  Complex psi_r{};                        ///< [Wb]
  std::function<void(double)> on_part{};  ///< called after each step of its integration [s]

  [[nodiscard]] Complex i_s() const { return (p_.l_r() * psi_s - p_.l_m * psi_r) / determinant(); }
  [[nodiscard]] double torque() const { return 1.5 * p_.pole_pairs * (std::conj(psi_s) * i_s()).imag(); }
  [[nodiscard]] double u_dc() const { return u_dc_; }

  /// The resistances of stator and rotor rise to this multiple; the fluxes stay.
  void warm(double factor) {
    p_.r_s *= factor;
    p_.r_r *= factor;
  }

  /// Applies a driven pattern, each segment in steps of at most 5 µs, or of 1 µs where `on_part` looks on.
  void apply(const GatePattern& pattern) {
    const int longest_ns = on_part ? 1'000 : 5'000;
    for (const GateSegment& segment : pattern.segments()) {
      const int steps = (segment.duration_ns + longest_ns - 1) / longest_ns;
      const double dt = segment.duration_ns * 1e-9 / steps;
      for (int k = 0; k < steps; ++k) {
        rk4(voltage(segment.state), dt);
        if (on_part) on_part(dt);
      }
    }
  }

  /// Gates off: the phase currents are taken to die linearly within the period; the rotor flux goes on.
  void coast(std::int32_t period_ns) {
    const Complex i_before = i_s();
    const double dt = period_ns * 1e-9;
    const auto slope = [&](double t, Complex psi) {
      const Complex i = i_before * (1 - t / dt);
      return p_.r_r / p_.l_r() * (p_.l_m * i - psi) + Complex{0, p_.pole_pairs * omega_m} * psi;
    };
    const Complex k1 = slope(0, psi_r);
    const Complex k2 = slope(dt / 2, psi_r + dt / 2 * k1);
    const Complex k3 = slope(dt / 2, psi_r + dt / 2 * k2);
    const Complex k4 = slope(dt, psi_r + dt * k3);
    psi_r += dt / 6 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    psi_s = p_.l_m / p_.l_r() * psi_r;
  }

  /// What a drive would measure now, after `applied`.
  template <class T>
  [[nodiscard]] Measurement<T> measure(const GatePattern& applied) const {
    Measurement<T> m;
    const Complex i = i_s();
    const double half_sqrt3 = 0.5 * std::sqrt(3.0);
    m.i_abc = {T(i.real()), T(-0.5 * i.real() + half_sqrt3 * i.imag()),
               T(-0.5 * i.real() - half_sqrt3 * i.imag())};
    m.u_dc = T(u_dc_);
    m.omega_m = T(omega_m);
    m.applied = applied;
    return m;
  }

 private:
  [[nodiscard]] double determinant() const { return p_.l_s() * p_.l_r() - p_.l_m * p_.l_m; }

  [[nodiscard]] Complex voltage(SwitchState s) const {
    const auto leg = [](LegState x) { return x == LegState::high ? 1.0 : 0.0; };
    const Complex a = std::polar(1.0, 2 * std::acos(-1.0) / 3);
    return 2.0 / 3.0 * u_dc_ * (leg(s.a()) + leg(s.b()) * a + leg(s.c()) * a * a);
  }

  void rk4(Complex u, double dt) {
    const auto s0 = psi_s;
    const auto r0 = psi_r;
    Complex sum_s{};
    Complex sum_r{};
    const double at[] = {0, 0.5, 0.5, 1};
    const double weight[] = {1, 2, 2, 1};
    Complex ds{};
    Complex dr{};
    for (int k = 0; k < 4; ++k) {
      psi_s = s0 + at[k] * dt * ds;
      psi_r = r0 + at[k] * dt * dr;
      const Complex i_r = (p_.l_s() * psi_r - p_.l_m * psi_s) / determinant();
      ds = u - p_.r_s * i_s();
      dr = -p_.r_r * i_r + Complex{0, p_.pole_pairs * omega_m} * psi_r;
      sum_s += weight[k] * ds;
      sum_r += weight[k] * dr;
    }
    psi_s = s0 + dt / 6 * sum_s;
    psi_r = r0 + dt / 6 * sum_r;
  }

  InductionMachineParameters<double> p_;
  double u_dc_;
};

/// The machine's parameters in another scalar.
template <class T, class U = double>
[[nodiscard]] InductionMachineParameters<T> converted(const InductionMachineParameters<U>& p) {
  return {T(p.r_s), T(p.r_r), T(p.l_ls), T(p.l_lr), T(p.l_m), p.pole_pairs, T(p.inertia)};
}

}  // namespace sextant::test
