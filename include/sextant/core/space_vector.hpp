#pragma once

#include <cmath>
#include <numbers>

namespace sextant {

/// Space vector in the stationary frame, amplitude-invariant: |x| is the peak of the phase quantity.
template <class T = double>
struct SpaceVector {
  T alpha{};  ///< along phase a
  T beta{};   ///< 90 electrical degrees ahead of alpha

  constexpr SpaceVector& operator+=(SpaceVector o) noexcept {
    alpha += o.alpha;
    beta += o.beta;
    return *this;
  }
  constexpr SpaceVector& operator-=(SpaceVector o) noexcept {
    alpha -= o.alpha;
    beta -= o.beta;
    return *this;
  }
  friend constexpr SpaceVector operator+(SpaceVector a, SpaceVector b) noexcept { return a += b; }
  friend constexpr SpaceVector operator-(SpaceVector a, SpaceVector b) noexcept { return a -= b; }
  friend constexpr SpaceVector operator*(T k, SpaceVector a) noexcept { return {k * a.alpha, k * a.beta}; }
  friend constexpr bool operator==(SpaceVector, SpaceVector) noexcept = default;
};

/// a · b.
template <class T>
[[nodiscard]] constexpr T dot(SpaceVector<T> a, SpaceVector<T> b) noexcept {
  return a.alpha * b.alpha + a.beta * b.beta;
}

/// a × b, the component out of the plane; positive when b leads a.
template <class T>
[[nodiscard]] constexpr T cross(SpaceVector<T> a, SpaceVector<T> b) noexcept {
  return a.alpha * b.beta - a.beta * b.alpha;
}

/// Product of two vectors as complex numbers.
template <class T>
[[nodiscard]] constexpr SpaceVector<T> product(SpaceVector<T> a, SpaceVector<T> b) noexcept {
  return {a.alpha * b.alpha - a.beta * b.beta, a.alpha * b.beta + a.beta * b.alpha};
}

/// Quotient of two vectors as complex numbers; b is not zero.
template <class T>
[[nodiscard]] constexpr SpaceVector<T> quotient(SpaceVector<T> a, SpaceVector<T> b) noexcept {
  return (T(1) / dot(b, b)) * SpaceVector<T>{dot(b, a), cross(b, a)};
}

/// j·a: a turned by +90 electrical degrees.
template <class T>
[[nodiscard]] constexpr SpaceVector<T> rotate_90(SpaceVector<T> a) noexcept {
  return {-a.beta, a.alpha};
}

template <class T>
[[nodiscard]] T magnitude(SpaceVector<T> a) noexcept {
  return std::sqrt(dot(a, a));
}

/// Unit vector along a; along the alpha axis where a is zero.
template <class T>
[[nodiscard]] SpaceVector<T> direction(SpaceVector<T> a) noexcept {
  const T length = magnitude(a);
  return length > T(0) ? (T(1) / length) * a : SpaceVector<T>{T(1), T(0)};
}

/// Angle from the alpha axis, in (-π, π]. [rad]
template <class T>
[[nodiscard]] T angle(SpaceVector<T> a) noexcept {
  return std::atan2(a.beta, a.alpha);
}

/// The vector of magnitude r at angle theta [rad] from the alpha axis.
template <class T>
[[nodiscard]] SpaceVector<T> polar(T r, T theta) noexcept {
  return {r * std::cos(theta), r * std::sin(theta)};
}

/// A quantity of three phases.
template <class T = double>
struct ThreePhase {
  T a{};
  T b{};
  T c{};
  friend constexpr bool operator==(ThreePhase, ThreePhase) noexcept = default;
};

/// Clarke transform, amplitude-invariant: x = 2/3 (x_a + x_b e^{j2π/3} + x_c e^{-j2π/3}).
/// The zero-sequence component (a + b + c)/3 is dropped.
template <class T>
[[nodiscard]] constexpr SpaceVector<T> clarke(ThreePhase<T> x) noexcept {
  constexpr T third = T(1) / T(3);
  return {third * (T(2) * x.a - x.b - x.c), std::numbers::inv_sqrt3_v<T> * (x.b - x.c)};
}

/// Inverse Clarke transform of a vector without zero sequence: x_a + x_b + x_c = 0.
template <class T>
[[nodiscard]] constexpr ThreePhase<T> inverse_clarke(SpaceVector<T> x) noexcept {
  constexpr T half_sqrt3 = std::numbers::sqrt3_v<T> / T(2);
  return {x.alpha, -x.alpha / T(2) + half_sqrt3 * x.beta, -x.alpha / T(2) - half_sqrt3 * x.beta};
}

}  // namespace sextant
