#pragma once

#include <array>
#include <cstddef>

namespace sextant {

/// The normal equations of a linear regression with n unknowns, A x = r, A symmetric and positive, by
/// Cholesky factors A = L D Lᵀ. Source: G. H. Golub, C. F. Van Loan, Matrix Computations, Baltimore 2013,
/// section 4.1.
template <class T, std::size_t n>
struct NormalEquations {
  using Row = std::array<T, n>;
  using Matrix = std::array<Row, n>;

  Matrix left{};  ///< A
  Row right{};    ///< r

  /// Zeros and `exists` false where A is not positive.
  struct Solution {
    bool exists{false};
    Row x{};
    Matrix factors{};  ///< L below the diagonal and D on it

    /// Of A. Costs n solutions.
    [[nodiscard]] constexpr Matrix inverse() const noexcept {
      Matrix out{};
      if (!exists) return out;
      for (std::size_t k = 0; k < n; ++k) {
        Row unit{};
        unit[k] = T(1);
        out[k] = back(factors, unit);
      }
      return out;
    }
  };

  /// Adds a prior of x: `weight` times the square of coefficients · x − value.
  constexpr void add(const Row& coefficients, T value, T weight) noexcept {
    for (std::size_t i = 0; i < n; ++i) {
      const T scaled = weight * coefficients[i];
      for (std::size_t k = 0; k < n; ++k) left[i][k] += scaled * coefficients[k];
      right[i] += scaled * value;
    }
  }
  /// Makes x_k zero, whatever the equations say.
  constexpr void fix(std::size_t k) noexcept {
    for (std::size_t i = 0; i < n; ++i) left[i][k] = left[k][i] = T(0);
    left[k][k] = T(1);
    right[k] = T(0);
  }

  /// The solution whose x_k is not below zero.
  [[nodiscard]] constexpr Solution solve_with_positive(std::size_t k) const noexcept {
    const Solution free = solve();
    if (!free.exists || free.x[k] >= T(0)) return free;
    NormalEquations without = *this;
    without.fix(k);
    return without.solve();
  }

  [[nodiscard]] constexpr Solution solve() const noexcept {
    Solution found{.factors = left};
    if (!factorise(found.factors)) return {};
    found.exists = true;
    found.x = back(found.factors, right);
    return found;
  }

 private:
  /// A becomes L below its diagonal and D on it; false where a pivot is not above zero.
  [[nodiscard]] static constexpr bool factorise(Matrix& a) noexcept {
    for (std::size_t k = 0; k < n; ++k) {
      if (!(a[k][k] > T(0))) return false;
      for (std::size_t i = k + 1; i < n; ++i) {
        const T factor = a[i][k] / a[k][k];
        for (std::size_t j = i; j < n; ++j) a[j][i] -= factor * a[j][k];
        a[i][k] = factor;
      }
    }
    return true;
  }
  [[nodiscard]] static constexpr Row back(const Matrix& a, Row y) noexcept {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < i; ++k) y[i] -= a[i][k] * y[k];
    }
    for (std::size_t i = n; i-- > 0;) {
      y[i] /= a[i][i];
      for (std::size_t k = i + 1; k < n; ++k) y[i] -= a[k][i] * y[k];
    }
    return y;
  }
};

}  // namespace sextant
