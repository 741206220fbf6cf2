#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/electrical_rates.hpp"
#include "sextant/plant/flux_pair.hpp"

namespace sextant {

/// How the fluxes of the machine move over a time h at constant speed and constant stator voltage. Written as
/// complex numbers they obey dx/dt = A x + b with a constant 2 x 2 matrix A, so that
///   x(t + h) = x(t) + W dx/dt(t),   W = h phi_1(h A),   phi_1(z) = (e^z − 1)/z
/// without any error of discretisation. W is a polynomial of A, by the theorem of Cayley and Hamilton of
/// degree one: W = a I + b A. The complex numbers a and b follow from the Taylor series of phi_1 by Horner's
/// rule, from trace and determinant of A alone; a long time is halved first and W(2h) = W(h)(2 I + A W(h))
/// doubles it again. Against the closed form by eigenvalues this needs no transcendental function and has no
/// cancellation, whether the eigenvalues are small or close together.
/// Source: N. J. Higham, "Functions of Matrices", SIAM, 2008, chapter 10.
template <class T = double>
class ElectricalTransition {
 public:
  /// Becomes the transition over h [s] at the electrical speed omega_e [rad/s]; in bounded time.
  void prepare(const ElectricalRates<T>& rates, T omega_e, T h) noexcept SEXTANT_NONBLOCKING {
    rates_ = rates;
    omega_e_ = omega_e;
    const int halvings = halvings_for((rates.ss + rates.sr + rates.rs + rates.rr + std::abs(omega_e)) * h);
    const T part = halvings == 0 ? h : std::ldexp(h, -halvings);
    // A is [−ss, sr; rs, −rr + j omega_e].
    const SpaceVector<T> trace{-(rates.ss + rates.rr), omega_e};
    const SpaceVector<T> determinant{rates.ss * rates.rr - rates.sr * rates.rs, -rates.ss * omega_e};
    sum_series(part * trace, (part * part) * determinant, part);
    for (int n = 0; n < halvings; ++n) twice(trace, determinant);
  }

  /// W x: the change of the fluxes whose derivative is x at the beginning. [V] → [Wb]
  [[nodiscard]] FluxPair<T> operator()(const FluxPair<T>& x) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> s = rates_.sr * x.r - rates_.ss * x.s;
    const SpaceVector<T> r = rates_.rs * x.s - rates_.rr * x.r + omega_e_ * rotate_90(x.r);
    return {product(a_, x.s) + product(b_, s), product(a_, x.r) + product(b_, r)};
  }

 private:
  static constexpr int degree = 8;
  /// Norm of h A up to which the series is exact: its remainder is 0.1⁹/10!, below 3e-16.
  static constexpr T radius = T(0.1);
  static constexpr int most_halvings = 60;

  /// 1/(k + 1)!
  static constexpr std::array<T, degree + 1> coefficients = [] {
    std::array<T, degree + 1> c{};
    T factorial{1};
    for (int k = 0; k <= degree; ++k) {
      factorial *= T(k + 1);
      c[std::size_t(k)] = T(1) / factorial;
    }
    return c;
  }();

  /// Product of complex numbers.
  static constexpr SpaceVector<T> product(SpaceVector<T> x, SpaceVector<T> y) noexcept SEXTANT_NONBLOCKING {
    return {x.alpha * y.alpha - x.beta * y.beta, x.alpha * y.beta + x.beta * y.alpha};
  }

  static int halvings_for(T norm) noexcept SEXTANT_NONBLOCKING {
    if (norm <= radius) [[likely]]
      return 0;
    return std::isfinite(norm) ? std::min(std::ilogb(norm / radius) + 1, most_halvings) : 0;
  }

  /// h phi_1 of the matrix M = h A with this trace and determinant; M² = trace M − determinant I.
  void sum_series(SpaceVector<T> trace, SpaceVector<T> determinant, T h) noexcept SEXTANT_NONBLOCKING {
    SpaceVector<T> a{coefficients[degree - 1], T(0)};
    SpaceVector<T> b{coefficients[degree], T(0)};
    for (std::size_t k = degree - 1; k-- > 0;) {
      const SpaceVector<T> before = a;
      a = SpaceVector<T>{coefficients[k], T(0)} - product(b, determinant);
      b = before + product(b, trace);
    }
    a_ = h * a;
    b_ = (h * h) * b;
  }

  /// W (2 I + A W) in place of W.
  void twice(SpaceVector<T> trace, SpaceVector<T> determinant) noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> c = SpaceVector<T>{T(2), T(0)} - product(b_, determinant);
    const SpaceVector<T> d = a_ + product(b_, trace);
    const SpaceVector<T> square = product(b_, d);
    b_ = product(a_, d) + product(b_, c) + product(square, trace);
    a_ = product(a_, c) - product(square, determinant);
  }

  ElectricalRates<T> rates_{};
  T omega_e_{};         ///< [rad/s]
  SpaceVector<T> a_{};  ///< [s]
  SpaceVector<T> b_{};  ///< [s²]
};

}  // namespace sextant
