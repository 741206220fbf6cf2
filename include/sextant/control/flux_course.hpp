#pragma once

#include <algorithm>

#include "sextant/control/parameter_covariance.hpp"
#include "sextant/control/parameter_prior.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// R_s, R_r and L_m by the course of the flux φ = k_r ψ_r in magnetising,
///   φ = φ_0 + a ∫i dt − b ∫φ dt,   a = k_r² R_r,   b = R_r/L_r,
/// where current i and voltage u behind the leakage are those along the flux, by linear regression with
/// Gaussian errors and prior (C. M. Bishop, Pattern Recognition and Machine Learning, New York 2006, section
/// 3.3). A course of some tenths of the rotor time constant tells little of b, so that noise of φ of a
/// percent is some ten percent of L_m. The prior (`ParameterPrior`) counts in proportion to the variance that
/// remains about the course, and to that of errors which the course itself takes up, such as those of the
/// sensors' gains: half a percent of the leakage flux σL_s i. With a large current and a short course these
/// make the prior of L_m count about half.
///   R_s = (∫u dt − a ∫i dt + b ∫φ dt)/∫i dt
/// A constant error δu of the voltage is an error δu/ī of R_s, ī the mean current; R_s follows as far as that
/// is small beside its prior.
template <class T = double>
class FluxCourse {
 public:
  using Machine = InductionMachineParameters<T>;

  struct Result {
    T r_s{};                              ///< [Ω]
    T r_r{};                              ///< [Ω]
    T l_m{};                              ///< [H]
    T flux{};                             ///< φ at the end [Wb]
    ParameterCovariance<T> covariance{};  ///< of R_s, R_r and L_m, as shares of those configured
  };

  /// Errors of the flux that a course takes up, by σL_s i. [-]
  static constexpr T systematic_share = T(5e-3);

  /// The parameters as configured; `correlation`: time over which errors of φ are correlated [s];
  /// voltage_error: standard deviation of δu [V].
  FluxCourse(const Machine& machine, T correlation, T voltage_error) noexcept
      : nominal_{machine},
        a_{machine.k_r() * machine.k_r() * machine.r_r},
        b_{T(1) / machine.tau_r()},
        correlation_{correlation},
        voltage_error_{voltage_error} {}

  /// One period of dt [s]: voltage behind the leakage [V] and current [A] along the flux, φ [Wb].
  void add(T voltage, T current, T flux, T dt) noexcept {
    if (!(time_ > T(0))) first_ = flux;
    time_ += dt;
    volt_seconds_ += dt * voltage;
    raised_ += a_ * dt * current;
    decayed_ += b_ * dt * flux;
    const T rest = flux - first_ - raised_ + decayed_;
    sums_.add(raised_, decayed_, rest, dt);
  }

  [[nodiscard]] T time() const noexcept { return time_; }  ///< [s]

  /// To be called after `add`.
  [[nodiscard]] Result solve() const noexcept {
    const Moments m = sums_.central(time_);
    const Shares free = m.solve(T(0));
    const T variance = m.rest_squared - free.a * m.raised_rest + free.b * m.decayed_rest;
    const T density = noise(variance / time_);
    const Shares share = m.solve(density);
    const T a = (T(1) + share.a) * raised_;
    const T b = (T(1) + share.b) * decayed_;
    const T start = first_ + (sums_.rest - share.a * sums_.raised + share.b * sums_.decayed) / time_;
    const T r_r = (T(1) + share.a) * nominal_.r_r;
    return {.r_s = r_s(volt_seconds_ - a + b),
            .r_r = r_r,
            .l_m = r_r / ((T(1) + share.b) * b_) - nominal_.l_lr,
            .flux = start + a - b,
            .covariance = covariance(m.normal(density), density)};
  }

  void reset() noexcept { *this = FluxCourse{nominal_, correlation_, voltage_error_}; }

 private:
  using Prior = ParameterPrior<T>;

  /// R_s by its volt-seconds. [Ω]
  [[nodiscard]] T r_s(T volt_seconds) const noexcept {
    if (!(raised_ > T(0))) return nominal_.r_s;
    const T seen = a_ * volt_seconds / raised_;
    return seen - (T(1) - stator_share()) * (seen - nominal_.r_s);
  }
  /// By how much of its error R_s follows, by the prior and by that of the voltage. [-]
  [[nodiscard]] T stator_share() const noexcept {
    const T error = a_ * time_ * voltage_error_;
    const T prior = Prior::r_s_deviation * nominal_.r_s * raised_;
    return prior * prior / (prior * prior + error * error);
  }

  /// Spectral density of the errors of φ, by the variance about the course [Wb²]. [Wb²·s]
  [[nodiscard]] T noise(T variance) const noexcept {
    const T current = raised_ / (a_ * time_);
    const T systematic = systematic_share * nominal_.sigma_l_s() * current;
    return std::max(T(0), variance) * correlation_ + systematic * systematic * time_;
  }

  /// By how much a and b exceed their nominal values, as shares of these. [-]
  struct Shares {
    T a{};
    T b{};
  };

  /// Of the normal equations for these shares. [Wb²·s]
  struct Normal {
    T aa{};
    T ab{};
    T bb{};
    [[nodiscard]] constexpr T determinant() const noexcept { return aa * bb - ab * ab; }
  };

  /// Second moments of a ∫i dt and b ∫φ dt with nominal a and b and of what they leave of φ. [Wb²·s]
  struct Moments {
    T raised_squared{}, raised_decayed{}, decayed_squared{};
    T raised_rest{}, decayed_rest{}, rest_squared{};

    /// The most probable shares; `noise`: spectral density of the errors of φ. [Wb²·s]
    [[nodiscard]] Shares solve(T noise) const noexcept {
      const Normal n = normal(noise);
      const T determinant = n.determinant();
      if (!(determinant > T(0))) return {};
      return {(raised_rest * n.bb - decayed_rest * n.ab) / determinant,
              (raised_rest * n.ab - decayed_rest * n.aa) / determinant};
    }
    [[nodiscard]] constexpr Normal normal(T noise) const noexcept {
      const T by_l = noise / (Prior::l_deviation * Prior::l_deviation);
      return {raised_squared + noise / (Prior::r_r_deviation * Prior::r_r_deviation) + by_l,
              raised_decayed + by_l, decayed_squared + by_l};
    }
  };

  struct Sums {
    T raised{}, decayed{}, rest{};
    Moments second{};

    void add(T x, T y, T z, T dt) noexcept {
      raised += dt * x;
      decayed += dt * y;
      rest += dt * z;
      second.raised_squared += dt * x * x;
      second.raised_decayed += dt * x * y;
      second.decayed_squared += dt * y * y;
      second.raised_rest += dt * x * z;
      second.decayed_rest += dt * y * z;
      second.rest_squared += dt * z * z;
    }
    /// About the means, because φ_0 is not known either.
    [[nodiscard]] Moments central(T time) const noexcept {
      const T x = raised / time;
      const T y = decayed / time;
      const T z = rest / time;
      return {second.raised_squared - x * raised,   second.raised_decayed - x * decayed,
              second.decayed_squared - y * decayed, second.raised_rest - x * rest,
              second.decayed_rest - y * rest,       second.rest_squared - z * rest};
    }
  };

  /// The shares α of a and β of b have the covariance density times the inverse of the normal equations'
  /// matrix. R_r exceeds its value by the share α, L_m by α − β and R_s by −(a/R_s)(α − β ∫bφ dt/∫ai dt).
  [[nodiscard]] ParameterCovariance<T> covariance(const Normal& n, T density) const noexcept {
    const T determinant = n.determinant();
    if (!(determinant > T(0) && raised_ > T(0))) return {};
    const T scale = density / determinant;
    const T aa = scale * n.bb;
    const T ab = scale * n.ab;
    const T bb = scale * n.aa;
    const T by = a_ / nominal_.r_s;
    const T ratio = decayed_ / raised_;
    const T share = stator_share();
    const T prior = Prior::r_s_deviation * Prior::r_s_deviation;
    return {.ss = share * share * by * by * (aa + ratio * ratio * bb - T(2) * ratio * ab) +
                  (T(1) - share) * prior,
            .sr = -share * by * (aa - ratio * ab),
            .sl = -share * by * (aa - ab - ratio * (ab - bb)),
            .rr = aa,
            .rl = aa - ab,
            .ll = aa + bb - T(2) * ab};
  }

  Machine nominal_;
  T a_;               ///< k_r² R_r [Ω]
  T b_;               ///< R_r/L_r [1/s]
  T correlation_;     ///< [s]
  T voltage_error_;   ///< [V]
  T time_{};          ///< [s]
  T first_{};         ///< φ at the begin [Wb]
  T volt_seconds_{};  ///< ∫u dt [Wb]
  T raised_{};        ///< a ∫i dt [Wb]
  T decayed_{};       ///< b ∫φ dt [Wb]
  Sums sums_{};
};

}  // namespace sextant
