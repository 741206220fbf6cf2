#pragma once

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The cubic polynomial of the time that has given values and slopes at both ends of a step: Hermite
/// interpolation in coefficients, for several instants within one step.
template <class Vector>
class Cubic {
 public:
  using T = typename Vector::Scalar;

  /// Values x and slopes v at the times 0 and h [s].
  void set(const Vector& x0, const Vector& v0, const Vector& x1, const Vector& v1,
           T h) noexcept SEXTANT_NONBLOCKING {
    const T k = T(1) / h;
    for (int i = 0; i < Vector::RowsAtCompileTime; ++i) {
      const T mean = k * (x1[i] - x0[i]);
      c0_[i] = x0[i];
      c1_[i] = v0[i];
      c2_[i] = k * (T(3) * mean - T(2) * v0[i] - v1[i]);
      c3_[i] = (k * k) * (v0[i] + v1[i] - T(2) * mean);
    }
  }

  [[nodiscard]] Vector operator()(T t) const noexcept SEXTANT_NONBLOCKING {
    Vector x;
    for (int i = 0; i < Vector::RowsAtCompileTime; ++i)
      x[i] = c0_[i] + t * (c1_[i] + t * (c2_[i] + t * c3_[i]));
    return x;
  }

 private:
  Vector c0_, c1_, c2_, c3_;
};

}  // namespace sextant
