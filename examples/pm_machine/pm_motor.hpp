// The drive's side of the example: estimate, available torque and field-oriented control of the machine, a
// sextant::MotorControl.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "pm_parameters.hpp"
#include "sextant/control/controller.hpp"
#include "sextant/control/space_vector_modulator.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/drive/motor_control.hpp"

namespace example {

/// Field-oriented control of a permanent-magnet machine by the measured angle of its rotor, which is zero
/// where the magnets' flux stands along phase a. The current stands at a constant angle beta from the q axis,
///   i_d = −I sin beta,   i_q = ±I cos beta
///   |tau_e| = 3/2 p cos beta (psi_m I + (L_q − L_d) sin beta I²)
/// Two PI controllers with the voltages of rotation make it. I is at most the current limit, and at most that
/// whose flux the link can turn, |psi_s| ≤ (u_dc/√3 − R_s I_limit)/(p |omega_m|).
template <class T = double>
class PmMotor {
 public:
  struct Parameters {
    PmParameters<T> machine{};
    T current_limit{T(9)};     ///< of the current vector [A]
    T current_angle{T(0.25)};  ///< beta [rad]
    T bandwidth{T(1500)};      ///< of the current controllers [rad/s]

    [[nodiscard]] const char* validate(const sextant::ControlTiming& timing) const noexcept {
      if (const char* problem = machine.validate()) return problem;
      if (!(std::isfinite(current_limit) && current_limit > T(0)))
        return "the current limit must be above zero";
      if (!(current_angle >= T(0) && current_angle < T(1)))
        return "the angle of the current must be from 0 to below 1 rad";
      if (!(bandwidth > T(0) && bandwidth * T(timing.period_ns) * T(1e-9) < T(0.5)))
        return "the bandwidth must be above zero and below half of the control frequency";
      return nullptr;
    }
    [[nodiscard]] T inertia() const noexcept { return machine.inertia; }
  };

  PmMotor(const Parameters& p, const sextant::ControlTiming& timing) noexcept
      : p_{p},
        period_ns_{timing.period_ns},
        dt_{T(timing.period_ns) * T(1e-9)},
        sin_{std::sin(p.current_angle)},
        cos_{std::cos(p.current_angle)},
        modulator_{{}} {
    estimate_.magnetised = true;
    estimate_.psi_s_magnitude = p.machine.psi_m;
  }

  [[nodiscard]] sextant::AvailableTorque<T> available(const sextant::Measurement<T>& m,
                                                      T /*dt*/) noexcept SEXTANT_NONBLOCKING {
    sextant::LimitedTorque<T> limit{torque_of(p_.current_limit), sextant::DeratingCause::current_limit};
    limit.lower_to({torque_of(current_within_voltage(m)), sextant::DeratingCause::voltage_limit});
    return {limit, limit};
  }

  /// The current controllers keep the current limit, as their references do.
  [[nodiscard]] sextant::LimitedTorque<T> present_limit(T /*enough*/) const noexcept SEXTANT_NONBLOCKING {
    return {};
  }

  [[nodiscard]] sextant::GatePattern step(const sextant::Measurement<T>& m,
                                          const sextant::MotorDemand<T>& demand,
                                          T /*dt*/) noexcept SEXTANT_NONBLOCKING {
    observe(m);
    reference_ = {demand.mode, demand.torque, T(1)};
    if (demand.mode == sextant::ControlMode::off) {
      integral_ = {};
      return {sextant::gates_off, period_ns_};
    }
    const Vector u = voltage(current_of(demand.torque), m.u_dc);
    // The pattern's mean voltage stands in its middle, half a period after it begins.
    return modulator_.step(turned(u, theta_ + T(0.5) * dt_ * omega_e_), m.u_dc, period_ns_);
  }

  void discard_pattern() noexcept SEXTANT_NONBLOCKING {
    reference_.mode = sextant::ControlMode::off;
    reference_.torque = T(0);
  }
  void restart() noexcept SEXTANT_NONBLOCKING { integral_ = {}; }

  /// The example has no parameters that change while it runs.
  [[nodiscard]] bool takes_parameters() const noexcept SEXTANT_NONBLOCKING { return false; }
  void take_parameters(const PmMotor& /*from*/) noexcept SEXTANT_NONBLOCKING {}

  [[nodiscard]] const sextant::ControlEstimate<T>& estimate() const noexcept SEXTANT_NONBLOCKING {
    return estimate_;
  }
  [[nodiscard]] const sextant::ControlReference<T>& reference() const noexcept SEXTANT_NONBLOCKING {
    return reference_;
  }
  [[nodiscard]] T flux_reference() const noexcept SEXTANT_NONBLOCKING { return p_.machine.psi_m; }

 private:
  using Vector = sextant::SpaceVector<T>;  // i_d and i_q, or u_d and u_q, as alpha and beta

  [[nodiscard]] static Vector turned(Vector x, T angle) noexcept SEXTANT_NONBLOCKING {
    return std::cos(angle) * x + std::sin(angle) * sextant::rotate_90(x);
  }
  [[nodiscard]] T pole_pairs() const noexcept SEXTANT_NONBLOCKING { return T(p_.machine.pole_pairs); }
  [[nodiscard]] Vector flux_of(Vector i) const noexcept SEXTANT_NONBLOCKING {
    return {p_.machine.l_d * i.alpha + p_.machine.psi_m, p_.machine.l_q * i.beta};
  }

  /// Of a current I [A]. [N·m]
  [[nodiscard]] T torque_of(T current) const noexcept SEXTANT_NONBLOCKING {
    const T saliency = (p_.machine.l_q - p_.machine.l_d) * sin_;
    return T(1.5) * pole_pairs() * cos_ * (p_.machine.psi_m + saliency * current) * current;
  }
  /// The inverse of it, with its direction. [A]
  [[nodiscard]] Vector current_of(T torque) const noexcept SEXTANT_NONBLOCKING {
    const T a = (p_.machine.l_q - p_.machine.l_d) * sin_;
    const T psi = p_.machine.psi_m;
    const T c = std::abs(torque) / (T(1.5) * pole_pairs() * cos_);
    const T current = std::min(p_.current_limit, T(2) * c / (psi + std::sqrt(psi * psi + T(4) * a * c)));
    return {-current * sin_, std::copysign(current * cos_, torque)};
  }
  /// The largest I whose flux the link can turn, from |psi_s|² = (psi_m − L_d I sin)² + (L_q I cos)². [A]
  [[nodiscard]] T current_within_voltage(const sextant::Measurement<T>& m) const noexcept
      SEXTANT_NONBLOCKING {
    const PmParameters<T>& x = p_.machine;
    const T omega_e = pole_pairs() * std::abs(m.omega_m);
    const T u = m.u_dc * std::numbers::inv_sqrt3_v<T> - x.r_s * p_.current_limit;
    if (!(u > T(0))) return T(0);
    const T d = x.l_d * sin_;
    const T q = x.l_q * cos_;
    const T a = d * d + q * q;
    const T b = x.psi_m * d;
    const T root = b * b - a * (x.psi_m * x.psi_m - (u / omega_e) * (u / omega_e));
    return root > T(0) ? std::max(T(0), (b + std::sqrt(root)) / a) : T(0);
  }

  /// Currents and estimate at the measurement.
  void observe(const sextant::Measurement<T>& m) noexcept SEXTANT_NONBLOCKING {
    theta_ = pole_pairs() * m.theta_m.value_or(T(0));
    omega_e_ = pole_pairs() * m.omega_m;
    i_ = turned(sextant::clarke(m.i_abc), -theta_);
    const Vector psi = flux_of(i_);
    estimate_.psi_s = turned(psi, theta_);
    estimate_.psi_s_magnitude = sextant::magnitude(psi);
    estimate_.torque = T(1.5) * pole_pairs() * sextant::cross(psi, i_);
    estimate_.r_s = p_.machine.r_s;
  }

  /// u = alpha L (i* − i) + I + j omega_e psi, dI/dt = alpha R_s (i* − i); where the link limits u, I follows
  /// what is left (back-calculation). [V]
  [[nodiscard]] Vector voltage(Vector i_ref, T u_dc) noexcept SEXTANT_NONBLOCKING {
    const Vector error = i_ref - i_;
    const Vector gained{p_.machine.l_d * error.alpha, p_.machine.l_q * error.beta};
    const Vector wanted = p_.bandwidth * gained + integral_ + omega_e_ * sextant::rotate_90(flux_of(i_));
    const Vector u = modulator_.within_hexagon(wanted, u_dc);
    integral_ += (p_.bandwidth * p_.machine.r_s * dt_) * error + (p_.bandwidth * dt_) * (u - wanted);
    return u;
  }

  Parameters p_;
  std::int32_t period_ns_;
  T dt_;   ///< control period [s]
  T sin_;  ///< of beta [-]
  T cos_;  ///< of beta [-]
  sextant::SpaceVectorModulator<T> modulator_;
  sextant::ControlEstimate<T> estimate_{};
  sextant::ControlReference<T> reference_{};
  Vector i_{};         ///< in the frame of the magnets [A]
  Vector integral_{};  ///< of the current controllers [V]
  T theta_{};          ///< angle of the magnets' flux, electrical [rad]
  T omega_e_{};        ///< its speed [rad/s]
};

static_assert(sextant::MotorControl<PmMotor<double>, double> && sextant::MotorControl<PmMotor<float>, float>);

}  // namespace example
