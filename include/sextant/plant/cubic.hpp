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
    const Vector mean = k * (x1 - x0);
    c0_ = x0;
    c1_ = v0;
    c2_ = k * (T(3) * mean - T(2) * v0 - v1);
    c3_ = (k * k) * (v0 + v1 - T(2) * mean);
  }

  [[nodiscard]] Vector operator()(T t) const noexcept SEXTANT_NONBLOCKING {
    return c0_ + t * (c1_ + t * (c2_ + t * c3_));
  }

  /// d²x/dt².
  [[nodiscard]] Vector curvature(T t) const noexcept SEXTANT_NONBLOCKING {
    return T(2) * c2_ + (T(6) * t) * c3_;
  }

 private:
  Vector c0_, c1_, c2_, c3_;
};

}  // namespace sextant
