#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "sextant/control/normal_equations.hpp"
#include "sextant/control/parameter_covariance.hpp"
#include "sextant/control/parameter_prior.hpp"
#include "sextant/control/saturation_shape.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// R_s, R_r and L_m by the course of the flux φ = k_r ψ_r in magnetising,
///   φ = φ_0 + a ∫i dt − b ∫φ dt − b s S,   a = k_r² R_r,   b = R_r/L_r,
/// where current i and voltage u behind the leakage are those along the flux, and s is an unknown of its own,
/// by which the iron saturates along the course S (`SaturationShape`): by linear regression with Gaussian
/// errors and prior (C. M. Bishop, Pattern Recognition and Machine Learning, New York 2006, section 3.3). A
/// course of some tenths of the rotor time constant tells little of b, so that noise of φ of a percent is
/// some ten percent of L_m. The prior (`ParameterPrior`) counts in proportion to the variance that remains
/// about the course, and to that of errors which the course itself takes up, such as those of the sensors'
/// gains: half a percent of the leakage flux σL_s i. With a large current and a short course these make the
/// prior of L_m count about half.
///   R_s = (∫u dt − a ∫i dt + b ∫φ dt + b s S)/∫i dt
/// A constant error δu of the voltage is an error δu/ī of R_s, ī the mean current; R_s follows as far as that
/// is small beside its prior.
template <class T = double>
class FluxCourse {
 public:
  using Machine = InductionMachineParameters<T>;
  using Saturation = typename SaturationShape<T>::Knowledge;

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
  /// voltage_error: standard deviation of δu [V]; flux_reference: ψ_ref [Wb];
  /// saturation: what is known of it.
  FluxCourse(const Machine& machine, T correlation, T voltage_error, T flux_reference,
             const Saturation& saturation = {}) noexcept
      : nominal_{machine},
        a_{machine.k_r() * machine.k_r() * machine.r_r},
        b_{T(1) / machine.tau_r()},
        correlation_{correlation},
        voltage_error_{voltage_error},
        shape_{machine, flux_reference, saturation} {}

  /// One period of dt [s]: voltage behind the leakage [V] and current [A] along the flux, φ [Wb].
  void add(T voltage, T current, T flux, T dt) noexcept {
    if (!(time_ > T(0))) {
      first_ = flux;
      shape_.begin(flux, current);
    }
    time_ += dt;
    volt_seconds_ += dt * voltage;
    course_[raised] += a_ * dt * current;
    course_[decayed] -= b_ * dt * flux;
    shape_.add(flux, current, dt);
    course_[bent] = -b_ * shape_.course();
    sums_.add(course_, flux - first_ - course_[raised] - course_[decayed], dt);
  }

  [[nodiscard]] T time() const noexcept { return time_; }  ///< [s]

  /// To be called after `add`.
  [[nodiscard]] Result solve() const noexcept {
    const Moments m = sums_.central(time_);
    const T density = noise((m.rest_squared - product(m.equations().solve().x, m.by_rest)) / time_);
    Equations equations = m.equations();
    add_priors(equations, density);
    const auto found = equations.solve_with_positive(bent);
    const Row& share = found.x;
    const T change = course_[raised] + course_[decayed] + product(share, course_);
    const T start = first_ + (sums_.rest - product(share, sums_.course)) / time_;
    const T r_r = (T(1) + share[raised]) * nominal_.r_r;
    return {.r_s = r_s(volt_seconds_ - change),
            .r_r = r_r,
            .l_m = r_r / ((T(1) + share[decayed]) * b_) - nominal_.l_lr,
            .flux = start + change,
            .covariance = found.exists ? covariance(found.inverse(), density) : ParameterCovariance<T>{}};
  }

  void reset() noexcept {
    time_ = first_ = volt_seconds_ = T(0);
    course_ = {};
    sums_ = {};
  }

 private:
  using Prior = ParameterPrior<T>;
  /// Parts of the course, and by how much a and b exceed their nominal values, as shares of these, and s.
  enum Part : std::size_t { raised, decayed, bent, parts };
  using Equations = NormalEquations<T, parts>;
  using Row = typename Equations::Row;
  using Matrix = typename Equations::Matrix;

  /// R_s by its volt-seconds. [Ω]
  [[nodiscard]] T r_s(T volt_seconds) const noexcept {
    if (!(course_[raised] > T(0))) return nominal_.r_s;
    const T seen = a_ * volt_seconds / course_[raised];
    return seen - (T(1) - stator_share()) * (seen - nominal_.r_s);
  }
  /// By how much of its error R_s follows, by the prior and by that of the voltage. [-]
  [[nodiscard]] T stator_share() const noexcept {
    const T error = a_ * time_ * voltage_error_;
    const T prior = Prior::r_s_deviation * nominal_.r_s * course_[raised];
    return prior * prior / (prior * prior + error * error);
  }

  /// Spectral density of the errors of φ, by the variance about the course [Wb²]. [Wb²·s]
  [[nodiscard]] T noise(T variance) const noexcept {
    const T current = course_[raised] / (a_ * time_);
    const T systematic = systematic_share * nominal_.sigma_l_s() * current;
    return std::max(T(0), variance) * correlation_ + systematic * systematic * time_;
  }

  /// density: of the errors of φ [Wb²·s]. L_r, R_r/b, exceeds its value by the difference of the shares.
  void add_priors(Equations& equations, T density) const noexcept {
    const auto weight = [density](T deviation) { return density / (deviation * deviation); };
    equations.add({T(1), T(0), T(0)}, T(0), weight(Prior::r_r_deviation));
    equations.add({T(1), T(-1), T(0)}, T(0), weight(Prior::l_deviation));
    equations.add({T(0), T(0), T(1)}, shape_.known().mean, weight(shape_.known().deviation));
  }

  [[nodiscard]] static constexpr T product(const Row& p, const Row& q) noexcept {
    T sum{};
    for (std::size_t n = 0; n < parts; ++n) sum += p[n] * q[n];
    return sum;
  }

  /// Second moments of the parts of the course and of what the nominal course leaves of φ. [Wb²·s]
  struct Moments {
    Matrix course{};
    Row by_rest{};
    T rest_squared{};

    [[nodiscard]] constexpr Equations equations() const noexcept {
      return {.left = course, .right = by_rest};
    }
  };

  struct Sums {
    Row course{};
    T rest{};
    Moments second{};

    constexpr void add(const Row& x, T z, T dt) noexcept {
      rest += dt * z;
      second.rest_squared += dt * z * z;
      for (std::size_t n = 0; n < parts; ++n) {
        course[n] += dt * x[n];
        second.by_rest[n] += dt * x[n] * z;
        for (std::size_t k = 0; k < parts; ++k) second.course[n][k] += dt * x[n] * x[k];
      }
    }
    /// About the means, because φ_0 is not known either.
    [[nodiscard]] constexpr Moments central(T time) const noexcept {
      Moments m = second;
      m.rest_squared -= rest * rest / time;
      for (std::size_t n = 0; n < parts; ++n) {
        m.by_rest[n] -= course[n] * rest / time;
        for (std::size_t k = 0; k < parts; ++k) m.course[n][k] -= course[n] * course[k] / time;
      }
      return m;
    }
  };

  /// R_r exceeds its value by the share α of a, L_m by α − β, β that of b, and R_s by −(a/R_s) times what the
  /// course changes with the shares, by ∫i dt.
  [[nodiscard]] ParameterCovariance<T> covariance(const Matrix& inverse, T density) const noexcept {
    if (!(course_[raised] > T(0))) return {};
    const T share = stator_share();
    const T by = -share * a_ / (nominal_.r_s * course_[raised]);
    Row of{};
    for (std::size_t n = 0; n < parts; ++n) of[n] = density * by * product(inverse[n], course_);
    const T prior = Prior::r_s_deviation * Prior::r_s_deviation;
    const T aa = density * inverse[raised][raised];
    const T ab = density * inverse[raised][decayed];
    const T bb = density * inverse[decayed][decayed];
    return {.ss = by * product(of, course_) + (T(1) - share) * prior,
            .sr = of[raised],
            .sl = of[raised] - of[decayed],
            .rr = aa,
            .rl = aa - ab,
            .ll = aa + bb - T(2) * ab};
  }

  Machine nominal_;
  T a_;                       ///< k_r² R_r [Ω]
  T b_;                       ///< R_r/L_r [1/s]
  T correlation_;             ///< [s]
  T voltage_error_;           ///< [V]
  SaturationShape<T> shape_;  ///< S
  T time_{};                  ///< [s]
  T first_{};                 ///< φ at the begin [Wb]
  T volt_seconds_{};          ///< ∫u dt [Wb]
  Row course_{};              ///< a ∫i dt, −b ∫φ dt, −b S [Wb]
  Sums sums_{};
};

}  // namespace sextant
