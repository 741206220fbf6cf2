#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/magnetising_points.hpp"

namespace sextant {

/// The magnetising current of the Γ circuit over the magnitude of the stator flux linkage, i(ψ), by points.
///
/// Between the points runs a cubic Hermite polynomial whose slopes make it monotone (PCHIP): at a point the
/// slope is the weighted harmonic mean of the secants on both sides, with steps h and secants m
///   1/d_k = (w_1/m_{k−1} + w_2/m_k)/(w_1 + w_2),   w_1 = 2 h_k + h_{k−1},   w_2 = h_k + 2 h_{k−1}
/// at zero, through which the curve goes as an odd function, that of the first secant, and at the end the one
/// of three points, not below the chord from zero. So di/dψ is continuous, as integrators of higher order
/// need, no measured curve gets waves, and the field's energy ∫ i dψ is a polynomial of degree four. Beyond
/// the last point the curve is a line. Source: F. N. Fritsch, J. Butland, "A method for constructing local
/// monotone piecewise cubic interpolants", SIAM J. Sci. Stat. Comput. 5 (1984) 300–304.
template <class T = double>
class MagnetisingTable {
 public:
  /// No points.
  constexpr MagnetisingTable() noexcept = default;

  /// The points must be valid.
  explicit MagnetisingTable(const MagnetisingPoints<T>& parameters) noexcept {
    for (const auto& [psi, current] : parameters.points) {
      if (last_ < MagnetisingPoints<T>::most) knots_[++last_] = {psi, current};
    }
    if (!acts()) return;
    find_slopes();
    for (std::size_t k = 0; k < last_; ++k)
      knots_[k + 1].energy = knots_[k].energy + energy_from(k, knots_[k + 1].psi - knots_[k].psi);
    find_largest_inductance();
  }

  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING { return last_ > 0; }

  /// i/ψ at a flux from zero on [Wb]. [1/H]
  [[nodiscard]] T by_flux(T psi) const noexcept SEXTANT_NONBLOCKING {
    const std::size_t k = piece(psi);
    if (k > 0) return current(k, psi) / psi;
    const Piece p = cubic(0);
    const T t = psi / p.h;
    return p.d + t * (p.c2 + t * p.c3);
  }
  /// di/dψ. [1/H]
  [[nodiscard]] T slope(T psi) const noexcept SEXTANT_NONBLOCKING {
    const std::size_t k = piece(psi);
    if (k == last_) return knots_[k].slope;
    const Piece p = cubic(k);
    const T t = (psi - knots_[k].psi) / p.h;
    return p.d + t * (T(2) * p.c2 + T(3) * p.c3 * t);
  }
  /// ∫ i dψ from zero flux. [A·Wb]
  [[nodiscard]] T energy(T psi) const noexcept SEXTANT_NONBLOCKING {
    const std::size_t k = piece(psi);
    return knots_[k].energy + energy_from(k, psi - knots_[k].psi);
  }
  /// ψ/i at most, within 4 % from above. [H]
  [[nodiscard]] constexpr T largest_inductance() const noexcept SEXTANT_NONBLOCKING {
    return largest_inductance_;
  }

 private:
  struct Knot {
    T psi{};      ///< [Wb]
    T current{};  ///< [A]
    T slope{};    ///< [1/H]
    T energy{};   ///< from zero flux on [A·Wb]
  };
  /// i = i_k + h (d t + c2 t² + c3 t³) with t = (ψ − ψ_k)/h.
  struct Piece {
    T h, d, c2, c3;
  };

  /// The knot before a flux, the last one beyond the end.
  [[nodiscard]] std::size_t piece(T psi) const noexcept SEXTANT_NONBLOCKING {
    std::size_t k = 0;
    while (k < last_ && !(psi < knots_[k + 1].psi)) ++k;
    return k;
  }
  [[nodiscard]] T secant(std::size_t k) const noexcept SEXTANT_NONBLOCKING {
    return (knots_[k + 1].current - knots_[k].current) / (knots_[k + 1].psi - knots_[k].psi);
  }
  [[nodiscard]] Piece cubic(std::size_t k) const noexcept SEXTANT_NONBLOCKING {
    const T m = secant(k), d = knots_[k].slope, next = knots_[k + 1].slope;
    return {knots_[k + 1].psi - knots_[k].psi, d, T(3) * m - T(2) * d - next, d + next - T(2) * m};
  }
  [[nodiscard]] T current(std::size_t k, T psi) const noexcept SEXTANT_NONBLOCKING {
    const T x = psi - knots_[k].psi;
    if (k == last_) return knots_[k].current + knots_[k].slope * x;
    const Piece p = cubic(k);
    const T t = x / p.h;
    return knots_[k].current + p.h * t * (p.d + t * (p.c2 + t * p.c3));
  }
  /// From knot k over x [Wb].
  [[nodiscard]] T energy_from(std::size_t k, T x) const noexcept SEXTANT_NONBLOCKING {
    if (k == last_) return x * (knots_[k].current + T(0.5) * knots_[k].slope * x);
    const Piece p = cubic(k);
    const T t = x / p.h;
    const T bent = t * t * (p.d / T(2) + t * (p.c2 / T(3) + t * p.c3 / T(4)));
    return x * knots_[k].current + p.h * p.h * bent;
  }
  void find_slopes() noexcept {
    const auto step = [this](std::size_t k) { return knots_[k + 1].psi - knots_[k].psi; };
    knots_[0].slope = secant(0);
    for (std::size_t k = 1; k < last_; ++k) {
      const T w1 = T(2) * step(k) + step(k - 1), w2 = step(k) + T(2) * step(k - 1);
      knots_[k].slope = (w1 + w2) / (w1 / secant(k - 1) + w2 / secant(k));
    }
    const T h = step(last_ - 1), before = step(last_ - 2);
    const T m = secant(last_ - 1), m_before = secant(last_ - 2);
    const T end = ((T(2) * h + before) * m - h * m_before) / (h + before);
    knots_[last_].slope = std::max(end, knots_[last_].current / knots_[last_].psi);
  }
  void find_largest_inductance() noexcept {
    constexpr int parts = 32;
    const Piece p = cubic(0);
    T least = std::min(p.d, p.d + p.c2 + p.c3);  // of i/ψ, a parabola up to the first point
    if (p.c3 > T(0)) {
      const T t = std::clamp(-p.c2 / (T(2) * p.c3), T(0), T(1));
      least = std::min(least, p.d + t * (p.c2 + t * p.c3));
    }
    for (std::size_t k = 1; k < last_; ++k) {
      const T h = (knots_[k + 1].psi - knots_[k].psi) / T(parts);
      for (int n = 0; n < parts; ++n) {
        const T psi = knots_[k].psi + T(n) * h;  // the current rises: i/ψ is no less up to the next part
        least = std::min(least, current(k, psi) / (psi + h));
      }
    }
    largest_inductance_ = T(1) / least;
  }

  std::size_t last_{};  ///< index of the last knot, the first is zero
  std::array<Knot, MagnetisingPoints<T>::most + 1> knots_{};
  T largest_inductance_{};  ///< [H]
};

}  // namespace sextant
