#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Measurements of an induction machine in steady state at constant rotor flux and slip, from its phasors:
///   i_s = ψ_r/L_m (1 + j ω_slip τ_r),   ψ_s = k_r ψ_r + σL_s i_s,   u_s = R_s i_s + j ω_e ψ_s
/// all turning at ω_e = p ω_m + ω_slip. The applied pattern of a period has the mean of u_s as its mean, to a
/// nanosecond of each segment. The currents have no ripple.
class SteadyMachine {
 public:
  static constexpr std::int32_t period_ns = 25'000;
  static constexpr double dt = 25e-6;
  static constexpr double u_dc = 2000.0;

  SteadyMachine(const InductionMachineParameters<double>& machine, double psi_r, double omega_m,
                double omega_slip) noexcept
      : machine_{machine}, psi_r_{psi_r}, omega_m_{omega_m}, omega_slip_{omega_slip} {}

  /// Steady state of a torque: 3/2 p k_r ψ_r i_q with i_q = ψ_r ω_slip τ_r/L_m.
  static SteadyMachine of_torque(const InductionMachineParameters<double>& machine, double psi_r,
                                 double omega_m, double torque) noexcept {
    const double i_q = torque / (1.5 * machine.pole_pairs * machine.k_r() * psi_r);
    return {machine, psi_r, omega_m, i_q * machine.l_m / (psi_r * machine.tau_r())};
  }

  [[nodiscard]] double torque() const noexcept {
    return 1.5 * machine_.pole_pairs * machine_.k_r() * psi_r_ * i_q();
  }
  [[nodiscard]] double omega_e() const noexcept { return machine_.pole_pairs * omega_m_ + omega_slip_; }
  [[nodiscard]] SpaceVector<double> psi_r(double t) const noexcept { return polar(psi_r_, omega_e() * t); }
  [[nodiscard]] SpaceVector<double> i_s(double t) const noexcept {
    const SpaceVector<double> direction = polar(1.0, omega_e() * t);
    return (psi_r_ / machine_.l_m) * direction + i_q() * rotate_90(direction);
  }

  /// The measurement at the end of period n.
  template <class T>
  [[nodiscard]] Measurement<T> measurement(std::int64_t n) const noexcept {
    const double t = double(n) * dt;
    const ThreePhase<double> i = inverse_clarke(i_s(t));
    return {.i_abc = {T(i.a), T(i.b), T(i.c)},
            .u_dc = T(u_dc),
            .omega_m = T(omega_m_),
            .applied = pattern(mean_voltage(t - dt, t))};
  }

 private:
  [[nodiscard]] double i_q() const noexcept { return psi_r_ * omega_slip_ * machine_.tau_r() / machine_.l_m; }

  /// (R_s ∫ i_s dt + Δψ_s)/dt. [V]
  [[nodiscard]] SpaceVector<double> mean_voltage(double from, double to) const noexcept {
    const auto psi_s = [this](double t) { return machine_.k_r() * psi_r(t) + machine_.sigma_l_s() * i_s(t); };
    // Simpson's rule.
    const SpaceVector<double> i_mean = (1.0 / 6.0) * (i_s(from) + 4.0 * i_s(0.5 * (from + to)) + i_s(to));
    return machine_.r_s * i_mean + (1.0 / (to - from)) * (psi_s(to) - psi_s(from));
  }

  /// Each leg is high for its share of the period: shares in proportion to the phase voltages.
  [[nodiscard]] static GatePattern pattern(SpaceVector<double> u) noexcept {
    const ThreePhase<double> v = inverse_clarke(u);
    const auto high_ns = [](double phase) {
      return std::int32_t(std::lround((0.5 + phase / u_dc) * double(period_ns)));
    };
    const std::int32_t ends[] = {high_ns(v.a), high_ns(v.b), high_ns(v.c)};
    GatePattern pattern;
    std::int32_t from = 0;
    while (from < period_ns) {
      std::int32_t to = period_ns;
      for (const std::int32_t end : ends) {
        if (end > from && end < to) to = end;
      }
      const auto leg = [&ends, from](int k) { return ends[k] > from ? LegState::high : LegState::low; };
      pattern.append({SwitchState{leg(0), leg(1), leg(2)}, to - from});
      from = to;
    }
    return pattern;
  }

  InductionMachineParameters<double> machine_;
  double psi_r_;
  double omega_m_;
  double omega_slip_;
};

}  // namespace sextant
