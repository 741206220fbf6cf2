#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/control/parameter_prior.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Relative standard deviations of R_s, R_r and L_m. [-]
template <class T = double>
struct ParameterDeviations {
  T r_s{};
  T r_r{};
  T l_m{};
};

/// What is not known of R_s, R_r and L_m: the covariance of δ, by how much the machine's exceed those in use,
/// as shares of these. After power-up it is that of `ParameterPrior`; identification and adaptation take away
/// what they see.
template <class T = double>
struct ParameterCovariance {
  using Prior = ParameterPrior<T>;

  T ss{Prior::r_s_deviation * Prior::r_s_deviation};  ///< of R_s
  T sr{Prior::warming * Prior::warming};              ///< of R_s and R_r
  T sl{};                                             ///< of R_s and L_m
  T rr{Prior::r_r_deviation * Prior::r_r_deviation};  ///< of R_r
  T rl{};                                             ///< of R_r and L_m
  T ll{Prior::l_deviation * Prior::l_deviation};      ///< of L_m

  /// One vector for each parameter: what it adds to an observation, or its gain by it.
  struct Rows {
    SpaceVector<T> s{};
    SpaceVector<T> r{};
    SpaceVector<T> l{};
  };

  /// The gain by which an observation y = H δ + error leaves the least of the covariance:
  ///   K = P Hᵀ (H P Hᵀ + v)⁻¹
  /// v: as `observe` has it, above zero.
  [[nodiscard]] constexpr Rows gain(const Rows& h, T variance) const noexcept {
    const Rows g = seen_by(h);
    const Square s = square(g, h, variance);
    const T scale = T(1) / (s.aa * s.bb - s.ab * s.ab);
    const auto row = [&s, scale](SpaceVector<T> of) {
      return scale * SpaceVector<T>{s.bb * of.alpha - s.ab * of.beta, s.aa * of.beta - s.ab * of.alpha};
    };
    return {row(g.s), row(g.r), row(g.l)};
  }

  /// The parameters follow an observation y = H δ + error by δ̂ = K y, with any gain K:
  ///   P ← (1 − K H) P (1 − K H)ᵀ + v K Kᵀ
  /// v: variance of each component of the error. Source: A. Gelb (ed.), Applied Optimal Estimation, Cambridge
  /// 1974, section 4.2.
  constexpr void observe(const Rows& h, const Rows& k, T variance) noexcept {
    const Rows g = seen_by(h);
    const Square q = square(g, h, variance);
    const auto less = [&q](SpaceVector<T> of, SpaceVector<T> gain) {
      return of - T(0.5) * SpaceVector<T>{q.aa * gain.alpha + q.ab * gain.beta,
                                          q.ab * gain.alpha + q.bb * gain.beta};
    };
    const Rows m{less(g.s, k.s), less(g.r, k.r), less(g.l, k.l)};
    ss -= T(2) * dot(k.s, m.s);
    sr -= dot(k.s, m.r) + dot(k.r, m.s);
    sl -= dot(k.s, m.l) + dot(k.l, m.s);
    rr -= T(2) * dot(k.r, m.r);
    rl -= dot(k.r, m.l) + dot(k.l, m.r);
    ll -= T(2) * dot(k.l, m.l);
  }

  /// dt [s] in which the machine may warm or cool, until no more is known than before the start.
  constexpr void age(T dt) noexcept {
    const ParameterCovariance prior{};
    const T more = Prior::warming * Prior::warming * std::min(T(1), dt / warming_time);
    if (ss + more > prior.ss || rr + more > prior.rr) return;
    ss += more;
    sr += more;
    rr += more;
  }

  /// Of parameters that are these multiples of the ones to which the shares refer.
  constexpr void refer_to(T r_s, T r_r, T l_m) noexcept {
    ss /= r_s * r_s;
    sr /= r_s * r_r;
    sl /= r_s * l_m;
    rr /= r_r * r_r;
    rl /= r_r * l_m;
    ll /= l_m * l_m;
  }

  /// Square roots of the variances, with the error by the sensors' gains, which no observation shows: a gain
  /// of all currents or voltages is the same change of every impedance.
  [[nodiscard]] ParameterDeviations<T> deviations() const noexcept {
    const auto of = [](T variance) {
      return std::sqrt(std::max(T(0), variance) + Prior::gain_error * Prior::gain_error);
    };
    return {of(ss), of(rr), of(ll)};
  }

 private:
  /// A symmetric matrix.
  struct Square {
    T aa{};
    T ab{};
    T bb{};
  };
  /// P Hᵀ.
  [[nodiscard]] constexpr Rows seen_by(const Rows& h) const noexcept {
    return {ss * h.s + sr * h.r + sl * h.l, sr * h.s + rr * h.r + rl * h.l, sl * h.s + rl * h.r + ll * h.l};
  }
  /// H P Hᵀ + v.
  [[nodiscard]] static constexpr Square square(const Rows& g, const Rows& h, T variance) noexcept {
    return {g.s.alpha * h.s.alpha + g.r.alpha * h.r.alpha + g.l.alpha * h.l.alpha + variance,
            g.s.alpha * h.s.beta + g.r.alpha * h.r.beta + g.l.alpha * h.l.beta,
            g.s.beta * h.s.beta + g.r.beta * h.r.beta + g.l.beta * h.l.beta + variance};
  }

  static constexpr T warming_time = T(600);  ///< in which a winding warms by `warming` [s]
};

/// s x + (1 − s) y, which is no less than the covariance of estimates that are mixed in these shares.
template <class T>
[[nodiscard]] constexpr ParameterCovariance<T> mixed(const ParameterCovariance<T>& x,
                                                     const ParameterCovariance<T>& y, T s) noexcept {
  const auto mix = [s](T a, T b) { return b + s * (a - b); };
  return {mix(x.ss, y.ss), mix(x.sr, y.sr), mix(x.sl, y.sl),
          mix(x.rr, y.rr), mix(x.rl, y.rl), mix(x.ll, y.ll)};
}

}  // namespace sextant
