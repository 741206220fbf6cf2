#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

#include "sextant/control/flux_course.hpp"
#include "sextant/control/normal_equations.hpp"
#include "sextant/control/parameter_covariance.hpp"
#include "sextant/control/parameter_prior.hpp"
#include "sextant/control/saturation_shape.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// R_s, R_r and L_m by the voltage in magnetising at standstill, where no voltage across the flux shows it.
/// With the integrals of voltage behind the leakage and current along the flux, U = ∫u dt and Q = ∫i dt, the
/// flux φ = k_r ψ_r is φ_0 + U − R_s Q, and
///   U = (R_s + a) Q − b ∫(φ_0 + U) dt + b R_s ∫Q dt,   a = k_r² R_r,   b = R_r/L_r.
/// Two errors that look like parameters are unknowns of their own. A constant error δu of the voltage, that u
/// lacks: with w = δu/i_0, i_0 the current of the first sample, and D = i_0 t − Q
///   U = (ρ + a) Q − b ∫(φ_0 + U) dt + b ρ ∫Q dt − w (D + b ∫D dt) − b s S,   R_s = ρ + w.
/// At a constant current D is zero, and the priors of R_s and δu alone share what ρ exceeds R_s by. And
/// saturation, by s and its course S (`SaturationShape`) of the flux by ρ: a larger ρ leaves less flux. S is
/// that to first order, S = S_0 + (ρ − R_s) dS/dρ, from the flux that the current makes by what is found at
/// the time,
///   dφ/dt = a i − b φ − b s G,
/// which a wrong ρ does not drive away.
///
/// Nonlinear regression, by one step of Gauss-Newton a millisecond, with `ParameterPrior` and the errors of
/// `FluxCourse`. Only the curve of U over a time of about τ_r tells R_s, R_r and L_r apart: the shorter the
/// course, the more the priors count. Source of the equations: P. Vas, Sensorless Vector and Direct Torque
/// Control, Oxford 1998.
template <class T = double>
class StandstillCourse {
 public:
  using Machine = InductionMachineParameters<T>;
  using Saturation = typename SaturationShape<T>::Knowledge;
  using Result = typename FluxCourse<T>::Result;

  /// The parameters as configured; voltage_error: standard deviation of δu [V]; flux_reference: ψ_ref [Wb];
  /// saturation: what is known of it.
  StandstillCourse(const Machine& machine, T voltage_error, T flux_reference,
                   const Saturation& saturation = {}) noexcept
      : nominal_{machine},
        a_{machine.k_r() * machine.k_r() * machine.r_r},
        b_{T(1) / machine.tau_r()},
        voltage_error_{voltage_error},
        shape_{machine, flux_reference, saturation} {}

  /// Magnetising begins at this flux φ_0. [Wb]
  void begin(T flux) noexcept {
    first_ = model_ = flux;
    time_ = since_sample_ = volt_seconds_ = charge_ = flux_seconds_ = charge_seconds_ = T(0);
    shape_.begin(flux, T(0));
    level_ = ohms_ = T(0);
    bend_ = shape_.known().mean;
    moments_ = {};
    shares_ = {};
    solution_ = {};
  }

  /// One period of dt [s]: voltage behind the leakage [V] and current [A] along the flux.
  void add(T voltage, T current, T dt) noexcept {
    volt_seconds_ += dt * voltage;
    charge_ += dt * current;
    flux_seconds_ += dt * (first_ + volt_seconds_);
    charge_seconds_ += dt * charge_;
    step_model(current, dt);
    const T excess = first_ + volt_seconds_ - nominal_.r_s * charge_ - model_;  // of ρ Q by that flux
    shape_.add(model_, current, dt, charge_ > T(0) ? excess / charge_ : T(0), -charge_);
    time_ += dt;
    since_sample_ += dt;
    if (since_sample_ < sample_time) return;
    sample(since_sample_);
    since_sample_ = T(0);
    improve();
  }

  /// By the samples so far.
  [[nodiscard]] Result result() const noexcept {
    Machine m = nominal_;
    m.r_s = (T(1) + shares_[0]) * nominal_.r_s + ohms_;
    m.r_r *= T(1) + shares_[1];
    m.l_m = (T(1) + shares_[2]) * nominal_.l_r() - nominal_.l_lr;
    return {.r_s = m.r_s,
            .r_r = m.r_r,
            .l_m = m.l_m,
            .flux = first_ + volt_seconds_ + ohms_ * level_ * time_ - m.r_s * charge_,
            .covariance = covariance()};
  }

 private:
  static constexpr T sample_time = T(1e-3);  ///< fewer sums round less in `float` [s]
  using Prior = ParameterPrior<T>;

  /// By how much ρ, R_r and L_r exceed their nominal values, as shares of these; ρ that of R_s. [-]
  using Shares = std::array<T, 3>;
  /// U less its nominal course, Q, ∫(φ_0 + U) dt, ∫Q dt, D, ∫D dt, S_0, dS/dρ; or their coefficients in the
  /// error of the course. D is zero until a current flows.
  using Terms = std::array<T, 8>;
  /// The shares, w and s.
  enum Unknown : std::size_t { rho, r_r, l_r, ohms, bend, unknowns };
  using Equations = NormalEquations<T, unknowns>;
  using Slopes = std::array<Terms, unknowns>;

  /// R_r/L_r as it is found. [1/s]
  [[nodiscard]] T decay() const noexcept { return b_ * (T(1) + shares_[r_r]) / (T(1) + shares_[l_r]); }

  void step_model(T current, T dt) noexcept {
    const T raise = a_ * (T(1) + shares_[r_r]) * current;
    model_ += dt * (raise - decay() * (model_ + bend_ * shape_.excess(model_, current)));
  }

  void sample(T dt) noexcept {
    const T r_s = nominal_.r_s;
    if (!(level_ > T(0))) level_ = std::max(T(0), charge_ / time_);
    const bool flows = level_ > T(0);
    const Terms z{volt_seconds_ - (r_s + a_) * charge_ + b_ * flux_seconds_ - b_ * r_s * charge_seconds_,
                  charge_,
                  flux_seconds_,
                  charge_seconds_,
                  flows ? level_ * time_ - charge_ : T(0),
                  flows ? T(0.5) * level_ * time_ * time_ - charge_seconds_ : T(0),
                  shape_.course(),
                  shape_.course_by()};
    for (std::size_t n = 0; n < z.size(); ++n) {
      for (std::size_t k = 0; k < z.size(); ++k) moments_[n][k] += dt * z[n] * z[k];
    }
  }

  /// One step of Gauss-Newton. w and s, which enter linearly but for the products of s and the shares, are
  /// found anew each time.
  void improve() noexcept {
    const Shares& x = shares_;
    const T r_s = nominal_.r_s * (T(1) + x[rho]);
    const T b_x = decay();
    const Terms error{T(1), -(r_s - nominal_.r_s + a_ * x[r_r]), b_x - b_, -(b_x * r_s - b_ * nominal_.r_s)};
    const T by_r_r = b_x / (T(1) + x[r_r]);
    const T by_l_r = -b_x / (T(1) + x[l_r]);
    const T r_s_excess = r_s - nominal_.r_s;
    const auto iron = [s = bend_, r_s_excess](T by) { return std::pair{by * s, by * s * r_s_excess}; };
    const auto [r_r_0, r_r_rho] = iron(by_r_r);
    const auto [l_r_0, l_r_rho] = iron(by_l_r);
    const Slopes slopes{
        Terms{T(0), -nominal_.r_s, T(0), -b_x * nominal_.r_s, T(0), T(0), T(0), b_x * bend_ * nominal_.r_s},
        Terms{T(0), -a_, by_r_r, -by_r_r * r_s, T(0), T(0), r_r_0, r_r_rho},
        Terms{T(0), T(0), by_l_r, -by_l_r * r_s, T(0), T(0), l_r_0, l_r_rho},
        Terms{T(0), T(0), T(0), T(0), T(1), b_x},
        Terms{T(0), T(0), T(0), T(0), T(0), T(0), b_x, b_x * r_s_excess}};
    const T density = noise();
    Equations equations = of_course(slopes, error);
    add_priors(equations, density);
    const auto found = equations.solve_with_positive(bend);
    if (!found.exists) return;
    const T before = T(1) + x[r_r];
    shares_ = bounded({x[rho] + found.x[rho], x[r_r] + found.x[r_r], x[l_r] + found.x[l_r]});
    model_ = first_ + (T(1) + shares_[r_r]) / before * (model_ - first_);
    ohms_ = found.x[ohms];
    bend_ = found.x[bend];
    solution_ = found;
    density_ = density;
  }

  [[nodiscard]] Equations of_course(const Slopes& slopes, const Terms& error) const noexcept {
    Equations out;
    for (std::size_t n = 0; n < unknowns; ++n) {
      const Terms weighted = weigh(slopes[n]);
      for (std::size_t k = 0; k < unknowns; ++k) out.left[n][k] = product(weighted, slopes[k]);
      out.right[n] = -product(weighted, error);
    }
    return out;
  }

  /// density: of the errors of U. [Wb²·s]
  void add_priors(Equations& equations, T density) const noexcept {
    const auto weight = [density](T deviation) { return density / (deviation * deviation); };
    const T by_ohm = T(1) / nominal_.r_s;
    equations.add({T(1), T(0), T(0), by_ohm, T(0)}, -shares_[rho], weight(Prior::r_s_deviation));
    equations.add({T(0), T(1), T(0), T(0), T(0)}, -shares_[r_r], weight(Prior::r_r_deviation));
    equations.add({T(0), T(0), T(1), T(0), T(0)}, -shares_[l_r], weight(Prior::l_deviation));
    equations.add({T(0), T(0), T(0), T(0), T(1)}, shape_.known().mean, weight(shape_.known().deviation));
    if (const T deviation = ohms_deviation(); deviation > T(0)) {
      equations.add({T(0), T(0), T(0), T(1), T(0)}, T(0), weight(deviation));
    } else {
      equations.fix(ohms);
    }
  }
  /// Of w; zero where there is no current. [Ω]
  [[nodiscard]] T ohms_deviation() const noexcept { return level_ > T(0) ? voltage_error_ / level_ : T(0); }

  /// Of the shares of R_s, which ρ and w move, R_r and L_r, which stands for L_m, by the last step.
  [[nodiscard]] ParameterCovariance<T> covariance() const noexcept {
    if (!solution_.exists) return {};
    const typename Equations::Matrix inverse = solution_.inverse();
    const T density = density_;
    const T by_ohm = ohms_deviation() > T(0) ? T(1) / nominal_.r_s : T(0);
    const auto row = [&inverse, by_ohm, density](std::size_t n) {
      return density * (inverse[n][rho] + by_ohm * inverse[n][ohms]);
    };
    return {row(rho) + by_ohm * row(ohms),
            row(r_r),
            row(l_r),
            density * inverse[r_r][r_r],
            density * inverse[r_r][l_r],
            density * inverse[l_r][l_r]};
  }

  /// Σ dt (p·z) z.
  [[nodiscard]] Terms weigh(const Terms& p) const noexcept {
    Terms sum{};
    for (std::size_t n = 0; n < p.size(); ++n) sum[n] = product(moments_[n], p);
    return sum;
  }

  [[nodiscard]] static constexpr T product(const Terms& p, const Terms& q) noexcept {
    T sum{};
    for (std::size_t n = 0; n < p.size(); ++n) sum += p[n] * q[n];
    return sum;
  }

  /// Spectral density of the errors of U. [Wb²·s]
  [[nodiscard]] T noise() const noexcept {
    const T current = time_ > T(0) ? charge_ / time_ : T(0);
    const T systematic = FluxCourse<T>::systematic_share * nominal_.sigma_l_s() * current;
    return systematic * systematic * time_;
  }

  /// Every parameter within the bounds of the prior; ρ may lie beyond those of R_s by three deviations of w.
  [[nodiscard]] Shares bounded(const Shares& x) const noexcept {
    const T room = T(3) * ohms_deviation() / nominal_.r_s;
    const auto within = [](T y) { return Prior::bounded(T(1) + y, T(1)) - T(1); };
    return {std::clamp(x[rho], Prior::lowest - T(1) - room, Prior::highest - T(1) + room), within(x[r_r]),
            within(x[l_r])};
  }

  Machine nominal_;
  T a_;                       ///< k_r² R_r [Ω]
  T b_;                       ///< R_r/L_r [1/s]
  T voltage_error_;           ///< of δu [V]
  SaturationShape<T> shape_;  ///< S
  T first_{};                 ///< φ_0 [Wb]
  T model_{};                 ///< φ by the current [Wb]
  T time_{};                  ///< [s]
  T since_sample_{};          ///< [s]
  T volt_seconds_{};          ///< U [Wb]
  T charge_{};                ///< Q [A·s]
  T flux_seconds_{};          ///< ∫(φ_0 + U) dt [Wb·s]
  T charge_seconds_{};        ///< ∫Q dt [A·s²]
  T level_{};                 ///< i_0; zero until a current flows [A]
  T ohms_{};                  ///< w [Ω]
  T bend_{};                  ///< s [-]
  std::array<Terms, std::tuple_size_v<Terms>> moments_{};
  Shares shares_{};
  typename Equations::Solution solution_{};  ///< of the last step
  T density_{};                              ///< of the errors of U in it [Wb²·s]
};

}  // namespace sextant
