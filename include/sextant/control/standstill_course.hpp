#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/control/flux_course.hpp"
#include "sextant/control/parameter_covariance.hpp"
#include "sextant/control/parameter_prior.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// R_s, R_r and L_m by the voltage in magnetising at standstill, where no voltage across the flux shows it.
/// With the integrals of voltage behind the leakage and current along the flux, U = ∫u dt and Q = ∫i dt, the
/// flux φ = k_r ψ_r is φ_0 + U − R_s Q, and
///   U = (R_s + a) Q − b ∫(φ_0 + U) dt + b R_s ∫Q dt,   a = k_r² R_r,   b = R_r/L_r.
/// A constant error δu of the voltage, that u lacks, is an unknown of its own: with w = δu/i_0, i_0 the
/// current of the first sample, and D = i_0 t − Q
///   U = (ρ + a) Q − b ∫(φ_0 + U) dt + b ρ ∫Q dt − w (D + b ∫D dt),   R_s = ρ + w.
/// At a constant current D is zero, and the priors of R_s and δu alone share what ρ exceeds R_s by.
/// Nonlinear regression, by one step of Gauss-Newton a millisecond, with `ParameterPrior` and the errors of
/// `FluxCourse`. Only the curve of U over a time of about τ_r
/// tells R_s, R_r and L_r apart: the shorter the course, the more the priors count. Source of the equations:
/// P. Vas, Sensorless Vector and Direct Torque Control, Oxford 1998.
template <class T = double>
class StandstillCourse {
 public:
  using Machine = InductionMachineParameters<T>;
  using Result = typename FluxCourse<T>::Result;

  /// The parameters as configured; voltage_error: standard deviation of δu. [V]
  StandstillCourse(const Machine& machine, T voltage_error) noexcept
      : nominal_{machine},
        a_{machine.k_r() * machine.k_r() * machine.r_r},
        b_{T(1) / machine.tau_r()},
        voltage_error_{voltage_error} {}

  /// Magnetising begins at this flux φ_0. [Wb]
  void begin(T flux) noexcept {
    *this = StandstillCourse{nominal_, voltage_error_};
    first_ = flux;
  }

  /// One period of dt [s]: voltage behind the leakage [V] and current [A] along the flux.
  void add(T voltage, T current, T dt) noexcept {
    volt_seconds_ += dt * voltage;
    charge_ += dt * current;
    flux_seconds_ += dt * (first_ + volt_seconds_);
    charge_seconds_ += dt * charge_;
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
            .covariance = covariance_};
  }

 private:
  static constexpr T sample_time = T(1e-3);  ///< fewer sums round less in `float` [s]
  using Prior = ParameterPrior<T>;
  static constexpr std::array<T, 3> deviations{Prior::r_s_deviation, Prior::r_r_deviation,
                                               Prior::l_deviation};  ///< of R_s, R_r and L_r [-]

  /// By how much ρ, R_r and L_r exceed their nominal values, as shares of these; ρ that of R_s. [-]
  using Shares = std::array<T, 3>;
  using Matrix = std::array<Shares, 3>;
  /// U less its nominal course, Q, ∫(φ_0 + U) dt, ∫Q dt, D, ∫D dt; or their coefficients in the error of the
  /// course. D is zero until a current flows.
  using Terms = std::array<T, 6>;

  void sample(T dt) noexcept {
    const T r_s = nominal_.r_s;
    if (!(level_ > T(0))) level_ = std::max(T(0), charge_ / time_);
    const bool flows = level_ > T(0);
    const Terms z{volt_seconds_ - (r_s + a_) * charge_ + b_ * flux_seconds_ - b_ * r_s * charge_seconds_,
                  charge_,
                  flux_seconds_,
                  charge_seconds_,
                  flows ? level_ * time_ - charge_ : T(0),
                  flows ? T(0.5) * level_ * time_ * time_ - charge_seconds_ : T(0)};
    for (std::size_t n = 0; n < z.size(); ++n) {
      for (std::size_t k = 0; k < z.size(); ++k) moments_[n][k] += dt * z[n] * z[k];
    }
  }

  /// One step of Gauss-Newton.
  void improve() noexcept {
    const Shares& x = shares_;
    const T r_s = nominal_.r_s * (T(1) + x[0]);
    const T b_x = b_ * (T(1) + x[1]) / (T(1) + x[2]);
    const Terms error{T(1), -(r_s - nominal_.r_s + a_ * x[1]), b_x - b_, -(b_x * r_s - b_ * nominal_.r_s)};
    const T by_r_r = b_x / (T(1) + x[1]);
    const T by_l_r = -b_x / (T(1) + x[2]);
    const std::array<Terms, 3> slopes{Terms{T(0), -nominal_.r_s, T(0), -b_x * nominal_.r_s},
                                      Terms{T(0), -a_, by_r_r, -by_r_r * r_s},
                                      Terms{T(0), T(0), by_l_r, -by_l_r * r_s}};
    const Terms by_ohms{T(0), T(0), T(0), T(0), T(1), b_x};
    const T density = noise();
    Matrix left{};
    Shares right{};
    Unknown ohms = unknown_ohms(by_ohms, error, density);
    for (std::size_t n = 0; n < 3; ++n) {
      const Terms weighted = weigh(slopes[n]);
      for (std::size_t k = 0; k < 3; ++k) left[n][k] = product(weighted, slopes[k]);
      const T prior = density / (deviations[n] * deviations[n]);
      left[n][n] += prior;
      right[n] = -product(weighted, error) - prior * x[n];
      ohms.across[n] += product(weighted, by_ohms);
    }
    ohms.eliminate(left, right);
    const Inverse inverse = inverse_of(left);
    shares_ = bounded(x, inverse.times(right));
    ohms_ = ohms.value({shares_[0] - x[0], shares_[1] - x[1], shares_[2] - x[2]});
    if (inverse.determinant > T(0)) covariance_ = inverse.covariance(density, ohms, nominal_.r_s);
  }

  /// A further unknown w of the normal equations: left · step + across w = right, across · step + own w =
  /// rest.
  struct Unknown {
    Shares across{};
    T own{};  ///< zero: w is known to be zero
    T rest{};

    /// Out of the equations of the others.
    void eliminate(Matrix& left, Shares& right) const noexcept {
      if (!(own > T(0))) return;
      for (std::size_t n = 0; n < 3; ++n) {
        for (std::size_t k = 0; k < 3; ++k) left[n][k] -= across[n] * across[k] / own;
        right[n] -= across[n] * rest / own;
      }
    }
    /// By the step of the others.
    [[nodiscard]] T value(const Shares& step) const noexcept {
      if (!(own > T(0))) return T(0);
      return (rest - across[0] * step[0] - across[1] * step[1] - across[2] * step[2]) / own;
    }
    /// By how much w moves with each of the others.
    [[nodiscard]] Shares slope() const noexcept {
      if (!(own > T(0))) return {};
      return {-across[0] / own, -across[1] / own, -across[2] / own};
    }
  };

  /// w, but for what the courses of the others add to `across`. Its priors are that of δu, and that of R_s,
  /// of which ρ and w are parts.
  [[nodiscard]] Unknown unknown_ohms(const Terms& by_ohms, const Terms& error, T density) const noexcept {
    const T deviation = ohms_deviation();
    if (!(deviation > T(0))) return {};
    const Terms weighted = weigh(by_ohms);
    const T r_s = deviations[0] * nominal_.r_s;
    const T by_r_s = density / (r_s * r_s);
    return {.across = {by_r_s * nominal_.r_s, T(0), T(0)},
            .own = product(weighted, by_ohms) + by_r_s + density / (deviation * deviation),
            .rest = -product(weighted, error) - by_r_s * nominal_.r_s * shares_[0]};
  }
  /// Of w; zero where there is no current. [Ω]
  [[nodiscard]] T ohms_deviation() const noexcept { return level_ > T(0) ? voltage_error_ / level_ : T(0); }

  /// Σ dt (p·z) z.
  [[nodiscard]] Terms weigh(const Terms& p) const noexcept {
    Terms sum{};
    for (std::size_t n = 0; n < p.size(); ++n) sum[n] = product(moments_[n], p);
    return sum;
  }

  [[nodiscard]] static constexpr T product(const Terms& p, const Terms& q) noexcept {
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3] + p[4] * q[4] + p[5] * q[5];
  }

  /// Spectral density of the errors of U. [Wb²·s]
  [[nodiscard]] T noise() const noexcept {
    const T current = time_ > T(0) ? charge_ / time_ : T(0);
    const T systematic = FluxCourse<T>::systematic_share * nominal_.sigma_l_s() * current;
    return systematic * systematic * time_;
  }

  /// Of a symmetric matrix: adjugate and determinant.
  struct Inverse {
    Matrix adjugate{};
    T determinant{};

    /// Zero where there is no inverse.
    [[nodiscard]] Shares times(const Shares& r) const noexcept {
      if (!(determinant > T(0))) return {};
      const auto dot = [&r, this](const Shares& p) {
        return (p[0] * r[0] + p[1] * r[1] + p[2] * r[2]) / determinant;
      };
      return {dot(adjugate[0]), dot(adjugate[1]), dot(adjugate[2])};
    }
    /// Of the shares of R_s, R_r and L_r, by the density of the errors that the matrix was made with: R_s
    /// moves with ρ and with w. r_s: to which its share refers [Ω]. L_r stands for L_m.
    [[nodiscard]] ParameterCovariance<T> covariance(T density, const Unknown& ohms, T r_s) const noexcept {
      const T scale = density / determinant;
      const Shares by = ohms.slope();
      const Shares of{T(1) + by[0] / r_s, by[1] / r_s, by[2] / r_s};
      const auto row = [&of, scale, this](std::size_t n) {
        return scale * (adjugate[n][0] * of[0] + adjugate[n][1] * of[1] + adjugate[n][2] * of[2]);
      };
      const T own = ohms.own > T(0) ? density / (ohms.own * r_s * r_s) : T(0);
      return {of[0] * row(0) + of[1] * row(1) + of[2] * row(2) + own,
              row(1),
              row(2),
              scale * adjugate[1][1],
              scale * adjugate[1][2],
              scale * adjugate[2][2]};
    }
  };

  [[nodiscard]] static Inverse inverse_of(const Matrix& m) noexcept {
    const auto minor = [](const Shares& p, const Shares& q, std::size_t n, std::size_t k) {
      return p[n] * q[k] - p[k] * q[n];
    };
    const Shares first{minor(m[1], m[2], 1, 2), minor(m[2], m[0], 1, 2), minor(m[0], m[1], 1, 2)};
    const Shares second{minor(m[1], m[2], 2, 0), minor(m[2], m[0], 2, 0), minor(m[0], m[1], 2, 0)};
    const Shares third{minor(m[1], m[2], 0, 1), minor(m[2], m[0], 0, 1), minor(m[0], m[1], 0, 1)};
    return {{first, second, third}, m[0][0] * first[0] + m[1][0] * first[1] + m[2][0] * first[2]};
  }

  /// x + step, with every parameter within the bounds of the prior; ρ may lie beyond those of R_s by three
  /// deviations of w.
  [[nodiscard]] Shares bounded(const Shares& x, const Shares& step) const noexcept {
    Shares y{};
    for (std::size_t n = 0; n < 3; ++n) y[n] = Prior::bounded(T(1) + x[n] + step[n], T(1)) - T(1);
    const T room = T(3) * ohms_deviation() / nominal_.r_s;
    if (room > T(0))
      y[0] = std::clamp(x[0] + step[0], Prior::lowest - T(1) - room, Prior::highest - T(1) + room);
    return y;
  }

  Machine nominal_;
  T a_;                 ///< k_r² R_r [Ω]
  T b_;                 ///< R_r/L_r [1/s]
  T first_{};           ///< φ_0 [Wb]
  T time_{};            ///< [s]
  T since_sample_{};    ///< [s]
  T volt_seconds_{};    ///< U [Wb]
  T charge_{};          ///< Q [A·s]
  T flux_seconds_{};    ///< ∫(φ_0 + U) dt [Wb·s]
  T charge_seconds_{};  ///< ∫Q dt [A·s²]
  std::array<Terms, std::tuple_size_v<Terms>> moments_{};
  T voltage_error_;  ///< of δu [V]
  T level_{};        ///< i_0; zero until a current flows [A]
  T ohms_{};         ///< w [Ω]
  Shares shares_{};
  ParameterCovariance<T> covariance_{};
};

}  // namespace sextant
