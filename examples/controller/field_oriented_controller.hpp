// Indirect field-oriented control with space-vector modulation: a control method outside of Sextant's tree.
// Beside it: the program (main.cpp), the conformance test (conformance.cpp), a scenario (torque_step.toml)
// and the project (CMakeLists.txt). docs/own_controller.md goes through them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

#include "sextant/config/control_method.hpp"
#include "sextant/control/controller.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace example {

/// Symmetric space-vector pattern of a stator voltage over one period: V0, two active vectors, V7 and back.
///   d_x = 1/2 + (u_x − (max u + min u)/2)/u_dc,  x = a, b, c
/// The mean voltage is exact up to |u| = u_dc/√3; a duty beyond 0…1 is cut. Segments of no duration drop out.
/// Source: J. Holtz, "Pulsewidth modulation: a survey", IEEE Trans. Ind. Electron. 39 (1992) 410–420.
template <class T>
[[nodiscard]] sextant::GatePattern space_vector_pattern(sextant::SpaceVector<T> u, T u_dc,
                                                        std::int32_t period_ns) noexcept SEXTANT_NONBLOCKING {
  const sextant::ThreePhase<T> phases = sextant::inverse_clarke(u);
  const std::array<T, 3> u_x{phases.a, phases.b, phases.c};
  const T middle = T(0.5) * (std::max({u_x[0], u_x[1], u_x[2]}) + std::min({u_x[0], u_x[1], u_x[2]}));
  std::array<std::int32_t, 3> on{};  // instant at which the leg goes high; it goes low as long before the end
  for (std::size_t x = 0; x < 3; ++x) {
    const T duty = u_dc > T(0) ? std::clamp(T(0.5) + (u_x[x] - middle) / u_dc, T(0), T(1)) : T(0.5);
    on[x] = std::int32_t(T(0.5) * (T(1) - duty) * T(period_ns));
  }
  std::array<std::int32_t, 8> edges{
      0, on[0], on[1], on[2], period_ns - on[0], period_ns - on[1], period_ns - on[2], period_ns};
  std::sort(edges.begin(), edges.end());
  sextant::GatePattern pattern;
  for (std::size_t k = 1; k < edges.size(); ++k) {
    const auto leg = [&](std::size_t x) {
      const bool high = edges[k - 1] >= on[x] && edges[k - 1] < period_ns - on[x];
      return high ? sextant::LegState::high : sextant::LegState::low;
    };
    pattern.append({{leg(0), leg(1), leg(2)}, edges[k] - edges[k - 1]});
  }
  return pattern;
}

/// Indirect rotor-flux orientation: the angle of the frame from speed and slip, currents by two PI
/// controllers.
///   dψ_r/dt = (L_m i_d − ψ_r)/τ_r,   dθ/dt = p ω_m + L_m i_q/(τ_r ψ_r),   T_e = 3/2 p k_r ψ_r i_q
/// Source: P. Vas, "Sensorless Vector and Direct Torque Control", Oxford 1998, section 2.1.
template <class T = double>
class FieldOrientedController final : public sextant::Controller<T> {
 public:
  static constexpr const char* name = "own_foc";
  static constexpr const char* meaning = "indirect field-oriented control with space-vector modulation";
  static constexpr std::array channels{
      sextant::ControlChannel{"i_d_a", "A", "stator current along the rotor flux"},
      sextant::ControlChannel{"i_q_a", "A", "stator current 90 degrees ahead of the rotor flux"},
      sextant::ControlChannel{"psi_r_wb", "Wb", "estimated magnitude of the rotor flux linkage"}};

  struct Parameters {
    // In common with the drive.
    sextant::InductionMachineParameters<T> machine{};
    std::int32_t period_ns{100'000};  ///< [ns]
    T flux_reference{T(1.1)};         ///< stator flux linkage without load [Wb]
    int actuation_delay_periods{0};   ///< [-]
    // Keys of [control.own_foc].
    T bandwidth{T(1000)};     ///< of the current controllers [rad/s]
    T current_limit{T(120)};  ///< of the current vector, from the drive [A]

    void set_basis(const sextant::ControlBasis<T>& basis) noexcept {
      machine = basis.machine;
      period_ns = basis.period_ns;
      flux_reference = basis.flux_reference;
      actuation_delay_periods = basis.actuation_delay_periods;
      current_limit = basis.current_limit;
    }
    [[nodiscard]] const char* validate() const noexcept {
      if (!(bandwidth * T(period_ns) * T(1e-9) < T(0.5))) return "the bandwidth is too high for the period";
      if (!(current_limit > flux_reference / machine.l_s()))
        return "the current limit is below that of the flux";
      return nullptr;
    }
  };

  explicit FieldOrientedController(const Parameters& p) noexcept
      : p_{p},
        dt_{T(p.period_ns) * T(1e-9)},
        k_r_{p.machine.k_r()},
        sigma_l_s_{p.machine.sigma_l_s()},
        no_load_flux_{p.flux_reference * p.machine.l_m / p.machine.l_s()},
        psi_reference_{no_load_flux_} {}

  [[nodiscard]] sextant::GatePattern step(const sextant::Measurement<T>& m,
                                          sextant::ControlReference<T> reference) noexcept
      SEXTANT_NONBLOCKING override {
    psi_reference_ = reference.flux_share * no_load_flux_;
    orient(m);
    if (reference.mode == sextant::ControlMode::off) {
      integral_ = {};
      return {sextant::gates_off, p_.period_ns};
    }
    const T torque = reference.mode == sextant::ControlMode::torque ? reference.torque : T(0);
    const sextant::SpaceVector<T> u = voltage(current_reference(torque), m.u_dc);
    // The pattern's mean voltage stands in its middle, half a period after it begins.
    const T ahead = (T(0.5) + T(p_.actuation_delay_periods)) * dt_;
    return space_vector_pattern(turned(u, theta_ + omega_e_ * ahead), m.u_dc, p_.period_ns);
  }

  void reset() noexcept SEXTANT_NONBLOCKING override {
    this->estimate_ = {};
    integral_ = i_ = {};
    theta_ = omega_e_ = psi_r_ = T(0);
    psi_reference_ = no_load_flux_;
    values_ = {};
  }

  /// Its current controllers integrate, and the torque of its estimate is that of the currents.
  [[nodiscard]] bool holds_mean_torque() const noexcept override { return true; }

  [[nodiscard]] std::span<const T> channel_values() const noexcept SEXTANT_NONBLOCKING override {
    return values_;
  }

 private:
  using Vector = sextant::SpaceVector<T>;  // i_d and i_q, or u_d and u_q, as alpha and beta

  [[nodiscard]] static Vector turned(Vector x, T angle) noexcept SEXTANT_NONBLOCKING {
    return std::cos(angle) * x + std::sin(angle) * sextant::rotate_90(x);
  }
  /// For divisions: no slip and no torque current belong to a flux that is not there. [Wb]
  [[nodiscard]] T usable_flux() const noexcept { return std::max(psi_r_, T(0.1) * psi_reference_); }

  /// Flux, angle and estimate at the measurement, after the time for which its pattern was applied.
  void orient(const sextant::Measurement<T>& m) noexcept SEXTANT_NONBLOCKING {
    const T elapsed = T(m.applied.duration_ns()) * T(1e-9);
    const T tau_r = p_.machine.tau_r();
    omega_e_ = T(p_.machine.pole_pairs) * m.omega_m + p_.machine.l_m * i_.beta / (tau_r * usable_flux());
    theta_ = std::remainder(theta_ + omega_e_ * elapsed, T(2) * std::numbers::pi_v<T>);
    i_ = turned(sextant::clarke(m.i_abc), -theta_);
    psi_r_ -= std::expm1(-elapsed / tau_r) * (p_.machine.l_m * i_.alpha - psi_r_);
    sextant::ControlEstimate<T>& e = this->estimate_;
    e.psi_s = turned(sigma_l_s_ * i_ + Vector{k_r_ * psi_r_, T(0)}, theta_);
    e.psi_s_magnitude = sextant::magnitude(e.psi_s);
    e.torque = T(1.5) * T(p_.machine.pole_pairs) * k_r_ * psi_r_ * i_.beta;
    e.magnetised = psi_r_ > T(0.97) * psi_reference_;
    values_ = {i_.alpha, i_.beta, psi_r_};
  }

  /// i_d holds the flux, and builds it up faster than its time constant; what the limit leaves is for i_q.
  /// [A]
  [[nodiscard]] Vector current_reference(T torque) const noexcept SEXTANT_NONBLOCKING {
    constexpr T flux_gain = T(20);
    const T steady = psi_reference_ / p_.machine.l_m;
    const T i_d = std::clamp(steady + flux_gain * (psi_reference_ - psi_r_) / p_.machine.l_m, T(0),
                             T(0.8) * p_.current_limit);
    const T limit = std::sqrt(p_.current_limit * p_.current_limit - i_d * i_d);
    const T i_q = torque / (T(1.5) * T(p_.machine.pole_pairs) * k_r_ * usable_flux());
    return {i_d, std::clamp(i_q, -limit, limit)};
  }

  /// u = K (i* − i) + I + u_ff with K = α σL_s, dI/dt = α (R_s + k_r² R_r)(i* − i) and the voltages of
  /// rotation u_ff; where the link limits u, I follows what is left (back-calculation). [V]
  [[nodiscard]] Vector voltage(Vector i_ref, T u_dc) noexcept SEXTANT_NONBLOCKING {
    const T gain = p_.bandwidth * sigma_l_s_;
    const T resistance = p_.machine.r_s + k_r_ * k_r_ * p_.machine.r_r;
    const Vector error = i_ref - i_;
    const Vector rotation{-omega_e_ * sigma_l_s_ * i_.beta,
                          omega_e_ * (sigma_l_s_ * i_.alpha + k_r_ * psi_r_)};
    const Vector wanted = gain * error + integral_ + rotation;
    const T size = sextant::magnitude(wanted);
    const T most = u_dc * std::numbers::inv_sqrt3_v<T>;
    const Vector u = size > most ? (most / size) * wanted : wanted;
    integral_ += (p_.bandwidth * resistance * dt_) * error + (p_.bandwidth * dt_) * (u - wanted);
    return u;
  }

  Parameters p_;
  T dt_;                       ///< control period [s]
  T k_r_;                      ///< [-]
  T sigma_l_s_;                ///< [H]
  T no_load_flux_;             ///< rotor flux that belongs to the configured stator flux without load [Wb]
  T psi_reference_;            ///< of the rotor flux: the share of it that the reference asks for [Wb]
  Vector i_{};                 ///< in the frame of the rotor flux [A]
  Vector integral_{};          ///< of the current controllers [V]
  T theta_{};                  ///< angle of the rotor flux, electrical [rad]
  T omega_e_{};                ///< its speed [rad/s]
  T psi_r_{};                  ///< its magnitude [Wb]
  std::array<T, 3> values_{};  ///< of the channels
};

/// The keys of [control.own_foc].
inline void describe(sextant::Description& d, FieldOrientedController<>::Parameters& p,
                     const FieldOrientedController<>::Parameters& /*by_default*/) {
  d.number("bandwidth_rad_s", p.bandwidth, {"rad/s", 1, 1e5, "bandwidth of the current controllers"});
}

}  // namespace example
